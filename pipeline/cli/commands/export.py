"""The command that exports the trajectory of a run for other programs."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli.console import messages_console
from pipeline.cli.options import RunArgument
from pipeline.cli.output import check_output
from pipeline.export.formats import MOST_DECIMALS, AngleUnit, Format, LengthUnit, Separator
from pipeline.stage import Stage


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
    output: Annotated[
        Path | None,
        typer.Option("--output", metavar="FILE", readable=False, help="Where to write to. Default: stdout."),
    ] = None,
    separator: Annotated[Separator, typer.Option(help="CSV: what separates values.")] = Separator.COMMA,
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
            help="CSV: columns by their names in trajectory.csv (always in SI units), separated by commas.",
        ),
    ] = None,
    length: Annotated[LengthUnit, typer.Option(help="CSV: unit of lengths.")] = LengthUnit.M,
    angle: Annotated[AngleUnit, typer.Option(help="CSV: unit of angles.")] = AngleUnit.RAD,
) -> None:
    """Write the trajectory of a run again: for another program, at another period, slower, or backwards.

    The motion is sampled from the path itself, not interpolated; its duration
    is stretched to the next whole number of periods, so that limits still
    hold and the last row is the goal at rest.
    """
    check_output(output, run)
    from pipeline.artifacts.output import write_output
    from pipeline.export import CsvOptions, format_samples
    from pipeline.retime import sample_trajectory, slowed, way_back
    from pipeline.run.reading import open_results, with_retime

    results = open_results(run, Stage.REFINE, Stage.RETIME)
    config = with_retime(results.config, period_s=period_s, speed=speed)
    trajectory = slowed(results.trajectory, 1.0 if speed is None else config.retime.speed)
    samples = sample_trajectory(way_back(config, trajectory) if back else trajectory, config.retime.period_s)
    names = None if columns is None else tuple(name.strip() for name in columns.split(",") if name.strip())
    options = CsvOptions(separator, decimals, names, length, angle)
    text = format_samples(kind, samples, results.machine.acceleration_mps2, config.export.joint_names, options)
    if output is None:
        typer.echo(text, nl=False)
        return
    write_output(output, text.encode())
    messages_console().print(
        f"{output}: {len(samples):,} rows {samples.period_s:g} s apart, {samples.duration_s:g} s", soft_wrap=True
    )


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        export,
        (
            "gantry-tau export results/agder --period 0.004 --output agder_4ms.csv",
            "gantry-tau export results/agder --format csv --period 0.001 | head",
            "gantry-tau export results/agder --format ros2 --speed 0.3 --output slow.yaml",
            "gantry-tau export results/agder --separator semicolon --length mm --columns t_s,q1_m,q2_m",
        ),
    ),
)
"""Every command with its examples."""
