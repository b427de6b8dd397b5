"""Commands that look at things: check a configuration, compare the paths of a run, report on it, export its motion."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli.comparing import compare
from pipeline.cli.console import messages_console, results_console
from pipeline.cli.runs import load
from pipeline.errors import UsageError
from pipeline.export.formats import MOST_DECIMALS, AngleUnit, Format, LengthUnit, Separator
from pipeline.stage import Stage

RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="The folder a run has written to.")]


def check(
    config: Annotated[Path | None, typer.Argument(metavar="CONFIG", help="The YAML file to check.")] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of configurations instead, for your editor.")
    ] = False,
) -> None:
    """Check a configuration, and show the machine: degrees of freedom, reach, grid, start and goal.

    A load that drives or links cannot hold at the start or the goal is told,
    with exit code 1.
    """
    if schema:
        from pipeline.config import Config

        typer.echo(json.dumps(Config.model_json_schema(), indent=2))
        return
    if config is None:
        raise UsageError("check needs a CONFIG, or --schema")
    import numpy as np

    from pipeline.cli.machine_report import machine_report
    from pipeline.limits.kappa import require_ends_below_cap
    from pipeline.machine.geometry import build_machine
    from pipeline.retime import require_ends_held
    from pipeline.route.regions.endpoints import task_endpoints

    loaded = load(config)
    machine = build_machine(loaded.machine)
    ends = task_endpoints(loaded, machine)
    require_ends_below_cap(loaded, [end.kappa for end in ends])
    console = results_console()
    for part in machine_report(loaded, machine, ends):
        console.print(part)
    require_ends_held(machine, np.stack([end.pose for end in ends]), np.stack([end.q_m[:3] for end in ends]))
    console.print(f"{config} is valid. Next: gantry-tau run {shlex.quote(str(config))}", soft_wrap=True)


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
        Path | None, typer.Option("--output", metavar="FILE", help="Where to write to. Default: stdout.")
    ] = None,
    separator: Annotated[Separator, typer.Option(help="CSV: what stands between values.")] = Separator.COMMA,
    decimals: Annotated[
        int | None,
        typer.Option(metavar="N", min=0, max=MOST_DECIMALS, help="CSV: decimals. Default: as the period needs."),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="CSV: columns by their names in trajectory.csv (in SI units always), comma separated.",
        ),
    ] = None,
    length: Annotated[LengthUnit, typer.Option(help="CSV: unit of lengths.")] = LengthUnit.M,
    angle: Annotated[AngleUnit, typer.Option(help="CSV: unit of angles.")] = AngleUnit.RAD,
) -> None:
    """Write the trajectory of a run once more: for another program, at another period, slower, or backwards.

    The motion is sampled anew from the path itself, not interpolated; its
    duration is stretched to the next whole number of periods, so that limits
    still hold and the last row is the goal at rest.
    """
    from pipeline.artifacts import write_whole
    from pipeline.export import CsvOptions, format_samples
    from pipeline.retime import sample_trajectory, slowed, way_back
    from pipeline.run.reading import open_results, with_retime

    results = open_results(run, Stage.REFINE, Stage.RETIME)
    if output is not None and output.resolve().is_relative_to(run.resolve()):
        raise UsageError(f"{output} is inside {run}, whose files are kept as they are: give another --output")
    config = with_retime(results.config, period_s=period_s, speed=speed)
    trajectory = slowed(results.trajectory, 1.0 if speed is None else config.retime.speed)
    samples = sample_trajectory(way_back(config, trajectory) if back else trajectory, config.retime.period_s)
    names = None if columns is None else tuple(name.strip() for name in columns.split(",") if name.strip())
    options = CsvOptions(separator, decimals, names, length, angle)
    text = format_samples(kind, samples, results.machine.acceleration_mps2, config.export.joint_names, options)
    if output is None:
        typer.echo(text, nl=False)
        return
    write_whole(output, text.encode())
    messages_console().print(
        f"{output}: {len(samples):,} rows {samples.period_s:g} s apart, {samples.duration_s:g} s", soft_wrap=True
    )


def report(
    run: RunArgument,
    output: Annotated[
        Path | None, typer.Option("--output", metavar="FILE", help="Where to write to. Default: report.html in RUN.")
    ] = None,
) -> None:
    """Write the report of a run once more: one page to open in a browser, without a server and offline.

    It shows what there is: a run that failed, or has not been run to its end,
    has a report, too, which says so. Runs that end, well or not, write theirs
    by themselves.
    """
    from pipeline.run.reporting import write_report

    if output is not None and output.resolve().is_relative_to(run.resolve()):
        raise UsageError(f"{output} is inside {run}, whose files are kept as they are: give another --output")
    with messages_console().status("writing the report"):
        target = write_report(run, output)
    results_console().print(f"{target}: {target.stat().st_size / 1e3:,.0f} kB", soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        check,
        (
            "gantry-tau check configs/agder.yaml",
            "gantry-tau check --schema > gantry-tau.schema.json",
            "and as the first line of a YAML file, so that editors complete it:",
            "# yaml-language-server: $schema=gantry-tau.schema.json",
        ),
    ),
    (
        compare,
        (
            "gantry-tau compare results/agder",
            "gantry-tau compare results/agder --markdown >> notes.md",
            "gantry-tau compare results/agder results/quick",
        ),
    ),
    (
        report,
        (
            "gantry-tau report results/agder",
            "gantry-tau report results/agder --output agder.html",
        ),
    ),
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
