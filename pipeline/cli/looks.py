"""Commands that look at things: check a configuration, compare the paths of a run, export its trajectory."""

import json
import shlex
from collections.abc import Callable
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.runs import load
from pipeline.errors import UsageError
from pipeline.stage import Stage

RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="The folder a run has written to.")]


class Format(StrEnum):
    """What trajectories can be exported as."""

    CSV = "csv"


def check(
    config: Annotated[Path | None, typer.Argument(metavar="CONFIG", help="The YAML file to check.")] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of configurations instead, for your editor.")
    ] = False,
) -> None:
    """Check a configuration, and show the machine: degrees of freedom, reach, grid, start and goal."""
    if schema:
        from pipeline.config import Config

        typer.echo(json.dumps(Config.model_json_schema(), indent=2))
        return
    if config is None:
        raise UsageError("check needs a CONFIG, or --schema")
    from pipeline.cli.machine_report import machine_report
    from pipeline.machine.geometry import build_machine
    from pipeline.route.ends import task_ends

    loaded = load(config)
    machine = build_machine(loaded.machine)
    console = results_console()
    for part in machine_report(loaded, machine, task_ends(loaded, machine)):
        console.print(part)
    console.print(f"{config} is valid. Next: gantry-tau run {shlex.quote(str(config))}", soft_wrap=True)


def compare(
    run: RunArgument,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a Markdown table.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
) -> None:
    """Compare the refined path with the route it came from, joined by straight lines in actuator space.

    Both are followed continuously and measured at the same number of points.
    Lengths and integrals are in steps of the route: a step is the largest
    move allowed in each coordinate.
    """
    if markdown and as_json:
        raise UsageError("--markdown and --json exclude each other")
    from pipeline.compare.metrics import TABLE_HEADER, comparison_rows, markdown_table, table_cells
    from pipeline.refine.measure import measure
    from pipeline.route.metric import step_sizes
    from pipeline.run.reading import open_results

    results = open_results(run, Stage.REFINE)
    steps = step_sizes(results.config.route)
    with messages_console().status("measuring both paths"):
        coarse, refined = (measure(samples, steps) for samples in results.samples)
    rows = comparison_rows(coarse, refined)
    if as_json:
        typer.echo(json.dumps([asdict(row) for row in rows], indent=2))
    elif markdown:
        typer.echo(markdown_table(rows), nl=False)
    else:
        table = Table(title=f"{results.config.name}: coarse path against refined path", title_justify="left")
        for index, heading in enumerate(TABLE_HEADER):
            table.add_column(heading, justify="right" if 2 <= index <= 5 else "left")
        for cells in table_cells(rows):
            table.add_row(*cells)
        results_console().print(table)


def export(
    run: RunArgument,
    kind: Annotated[Format, typer.Option("--format", help="What to write.")] = Format.CSV,
    period_s: Annotated[
        float | None,
        typer.Option("--period", metavar="S", help="Seconds between rows. Default: that of the run."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", metavar="FILE", help="Where to write to. Default: stdout.")
    ] = None,
) -> None:
    """Write the trajectory of a run once more, at another period.

    The motion is sampled anew from the path itself, not interpolated; its
    duration is stretched to the next whole number of periods, so that limits
    still hold and the last row is the goal at rest.
    """
    from pipeline.artifacts import write_whole
    from pipeline.export import format_csv, trajectory_columns
    from pipeline.retime import sample
    from pipeline.run.reading import open_results, with_period

    results = open_results(run, Stage.REFINE, Stage.RETIME)
    if output is not None and output.resolve().is_relative_to(run.resolve()):
        raise UsageError(f"{output} is inside {run}, whose files are kept as they are: give another --output")
    period_s = with_period(results.config, period_s).retime.period_s
    samples = sample(results.trajectory, period_s)
    text = {Format.CSV: format_csv}[kind](trajectory_columns(samples))
    if output is None:
        typer.echo(text, nl=False)
        return
    write_whole(output, text.encode())
    messages_console().print(
        f"{output}: {len(samples):,} rows {period_s:g} s apart, {samples.duration_s:g} s", soft_wrap=True
    )


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
    (compare, ("gantry-tau compare results/agder", "gantry-tau compare results/agder --markdown >> notes.md")),
    (
        export,
        (
            "gantry-tau export results/agder --period 0.004 --output agder_4ms.csv",
            "gantry-tau export results/agder --format csv --period 0.001 | head",
        ),
    ),
)
"""Every command with its examples."""
