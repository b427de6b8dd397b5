"""The command that exports the trajectory of a run for other programs."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console
from pipeline.cli.motions.driven import driven
from pipeline.cli.motions.rows import interpolated_by_controller
from pipeline.cli.options import RunArgument
from pipeline.cli.output import check_output, refuse_same
from pipeline.errors import UsageError
from pipeline.export.formats import (
    MOST_DECIMALS,
    TOLERANCE_M,
    TRIP_LIMITS,
    TRIP_YAML,
    AngleUnit,
    DecimalMark,
    Format,
    LengthUnit,
    Separator,
    Times,
)

if TYPE_CHECKING:
    from pipeline.arrays import FloatArray
    from pipeline.certify.recheck.tube import ProvenTube
    from pipeline.retime.result import Trajectory, TrajectorySamples


def export(
    run: RunArgument,
    kind: Annotated[Format, typer.Option("--format", help="What to write.")] = Format.CSV,
    period_s: Annotated[
        float | None,
        typer.Option("--period", metavar="S", help="Seconds between rows. Default: that of the run."),
    ] = None,
    speed: Annotated[
        float | None, typer.Option(metavar="PART", help="Part of the run's speed, above 0, at most 1.")
    ] = None,
    back: Annotated[bool, typer.Option("--back", help="The way back: the same motion, reversed in time.")] = False,
    safe: Annotated[
        bool,
        typer.Option(
            "--safe", help="Slow down until cubics or quintics between rows, as the format is read, keep all limits."
        ),
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", readable=False, help="Where to write to. Default: stdout."),
    ] = None,
    separator: Annotated[Separator, typer.Option(help="CSV, PVT: what separates values.")] = Separator.COMMA,
    decimal: Annotated[DecimalMark, typer.Option(help="CSV, PVT: decimal point or comma.")] = DecimalMark.POINT,
    decimals: Annotated[
        int | None,
        typer.Option(
            metavar="N", min=0, max=MOST_DECIMALS, help="CSV: decimals. Default: as many as the period needs."
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="CSV: columns by their names in trajectory.csv (always in SI units), and jerk, qddd1_mps3 to "
            "qddd5_mps3; separated by commas.",
        ),
    ] = None,
    names: Annotated[
        str | None,
        typer.Option(metavar="NAMES", help="CSV, PVT: other names for the columns, in their order."),
    ] = None,
    length: Annotated[LengthUnit, typer.Option(help="CSV, PVT, cam, LinuxCNC: unit of lengths.")] = LengthUnit.M,
    angle: Annotated[AngleUnit, typer.Option(help="CSV: unit of angles.")] = AngleUnit.RAD,
    times: Annotated[Times, typer.Option(help="PVT: times since the start, or since the row before.")] = Times.ABSOLUTE,
    lead_in_s: Annotated[
        float,
        typer.Option("--lead-in", metavar="S", help="ROS 2, MCAP: seconds in which to reach the first point."),
    ] = 0.0,
    tolerance_m: Annotated[
        float,
        typer.Option("--tolerance", metavar="M", help="Cam: how far positions may be off between its points."),
    ] = TOLERANCE_M,
) -> None:
    """Write the trajectory of a run again: for another program, at another period, slower, or backwards.

    The motion is sampled from the path itself, not interpolated; its duration
    is stretched to the next whole number of periods, so that limits still
    hold and the last row is the goal at rest. What a controller makes of the
    rows by its own interpolation may exceed limits between them: that is
    warned of, and --safe slows the motion down until it does not. Only what
    a format is read by counts: cubics for pvt, quintics for ROS 2, lines for
    LinuxCNC, all of them otherwise. Velocities of lines jump at any speed.
    """
    beside = {} if output is None else {suffix: output.with_suffix(suffix) for suffix in kind.beside}
    for path in (output, *beside.values()):
        check_output(path, run)
    for suffix, path in beside.items():
        refuse_same(output, path, f"--output and the {suffix} file beside it")
    from pipeline.export import ExportOptions, ExportRequest, export_files
    from pipeline.machine.actuator_space.controller_units import controller_units
    from pipeline.retime import interpolations, sample_trajectory, whole_periods
    from pipeline.run.reading import open_tubes

    wanted, named = _listed(columns), _listed(names)
    options = ExportOptions(separator, decimals, wanted, length, angle, decimal, named, times, lead_in_s, tolerance_m)
    trajectory, config = driven(run, speed, period_s, back)
    trajectory = interpolated_by_controller(kind, trajectory, config, safe=safe)
    samples = sample_trajectory(trajectory, config.retime.period_s)
    machine = trajectory.path.machine
    tube = next(iter(open_tubes(run)), None) if TRIP_LIMITS & set(beside) else None
    request = ExportRequest(
        samples,
        machine.acceleration_mps2,
        config.export.joint_names,
        options,
        machine,
        _jerk(trajectory, samples),
        tube=tube,
        units=controller_units(config.machine),
    )
    if tube is not None and TRIP_YAML in beside:
        found = interpolations(whole_periods(trajectory, samples.period_s), samples)
        off = {one.method: one.deviation_m for one in found}
        # What reads this file drives polynomials of degree five.
        request = replace(request, deviation_m=off["quintic"])
    files = export_files(kind, request)
    _write(kind, files, output, beside)
    if output is not None:
        also = "".join(f", and {beside[suffix]}" for suffix in beside if suffix in files)
        messages_console().print(f"{output}: {_content(kind, samples)}{also}", soft_wrap=True)
    for suffix, path in beside.items():
        if suffix not in files:
            messages_console().print(_without_limits(path, run, tube), soft_wrap=True)
        elif tube is not None and suffix in TRIP_LIMITS:
            text = f"{path}: trip limits; with drives up to {1e3 * tube.errors_m[0]:.4g} mm off the path {tube.meaning}"
            messages_console().print(text, soft_wrap=True)


def _content(kind: Format, samples: "TrajectorySamples") -> str:
    """Say what a file holds: some formats leave points out, and some hold no motion."""
    if not kind.reader:
        return "the machine, without a motion"
    points = "points that meet " if "tolerance_m" in kind.options else ""
    return f"{points}{len(samples):,} rows {samples.period_s:g} s apart, {samples.duration_s:g} s"


def _without_limits(path: Path, run: Path, tube: "ProvenTube | None") -> str:
    """Say why there is no file with trip limits, and how to get one."""
    from pipeline.artifacts.layout import CONFIG

    if tube is not None:
        return (
            f"{path} is not written: nothing of the proven tolerance is left at this period; choose a shorter --period"
        )
    return (
        f"{path} is not written, which would have trip limits: how far drives may be off the path is not proven.\n"
        f"  gantry-tau certify {run / CONFIG} --out {run} --following   (half a minute), then export again"
    )


def _listed(names: str | None) -> tuple[str, ...] | None:
    return None if names is None else tuple(name.strip() for name in names.split(",") if name.strip())


def _jerk(trajectory: "Trajectory", samples: "TrajectorySamples") -> "FloatArray | None":
    """Evaluate jerk (n, 5) at the times of the samples; None where accelerations jump."""
    from pipeline.retime.sampling import whole_periods

    if trajectory.jerk_jumps:
        return None
    return whole_periods(trajectory, samples.period_s).q(samples.t_s, 3)


def _write(kind: Format, files: dict[str, bytes], output: Path | None, beside: dict[str, Path]) -> None:
    from pipeline.artifacts.output import is_written_through, write_output

    if output is None:
        if kind is Format.MCAP and sys.stdout.isatty():
            raise UsageError("a bag is not text: give --output FILE, or a pipe")
        typer.echo(files[""], nl=False)
        return
    if not is_written_through(output):
        for suffix, path in beside.items():
            if suffix in files:
                write_output(path, files[suffix])
    write_output(output, files[""])


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        export,
        (
            "gantry-tau export results/agder --period 0.004 --output agder_4ms.csv",
            "gantry-tau export results/agder --format csv --period 0.001 | head",
            "gantry-tau export results/agder --safe --output safe.csv",
            "gantry-tau export results/agder --format ros2 --speed 0.3 --lead-in 2 --output slow.yaml",
            "gantry-tau export results/agder --separator semicolon --decimal comma --columns t_s,q1_m,q2_m",
            "gantry-tau export results/agder --format mjcf --output agder.xml",
        ),
    ),
)
"""Every command with its examples."""
