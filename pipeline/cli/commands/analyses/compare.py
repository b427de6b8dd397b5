"""The command that compares the two paths of a run, or several runs."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.output import text_table
from pipeline.errors import NoSolutionError, UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.compare import MeasuredPath, MotionFigures
    from pipeline.config import RetimeConfig
    from pipeline.refine.result import Path
    from pipeline.run import Results

_MM = 1e-3


def compare(
    runs: Annotated[list[FilePath], typer.Argument(metavar="RUN [RUN ...]", help="The folders runs have written to.")],
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a Markdown table.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
    blend_mm: Annotated[
        float,
        typer.Option("--blend", metavar="MM", min=0.1, max=100.0, help="How far the coarse path may cut its corners."),
    ] = 5.0,
    timing: Annotated[
        bool, typer.Option("--timing/--no-timing", help="Time the paths, which takes seconds each, or do not.")
    ] = True,
) -> None:
    """Compare the refined path of a run with its route, or the refined paths of several runs with the first one's.

    The route is joined by straight lines in actuator space: its coarse path.
    All paths are followed continuously and measured at the same number of
    points. Lengths and integrals are in steps of the (first) run's route: a
    step is the largest move allowed in each coordinate. kappa is taken with
    the (first) run's machine.characteristic_length_m.

    For durations and peaks the coarse path is driven as a controller would
    drive it, with rounded corners (--blend, in actuator space). All paths are
    timed with the settings of the (first) run, at full speed, within the
    limits of their own machine. "Equally long" means the peaks of the same
    motions, slowed down to the duration of the slowest.
    """
    if markdown and as_json:
        raise UsageError("--markdown and --json exclude each other")
    from pipeline.run.reading import open_results

    results = [open_results(run, Stage.REFINE) for run in runs]
    _warn_unproven(results)
    if len(results) == 1:
        _compare_paths(results[0], markdown, as_json, blend_mm, timing)
    else:
        _compare_runs(results, markdown, as_json, timing)


def _warn_unproven(results: "Sequence[Results]") -> None:
    """Name the refined paths without a certificate: their figures do not show that they may meet a singularity."""
    from pipeline.artifacts import read_state

    for one, name in zip(results, _names(results), strict=True):
        state = read_state(one.folder)
        record = None if state is None else state.stages.get(Stage.CERTIFY)
        if record is None or record.summary.get("verdict") != "certified" or record.damage(one.folder):
            messages_console().print(f"{name}: the refined path is not certified", soft_wrap=True)


def _compare_paths(results: "Results", markdown: bool, as_json: bool, blend_mm: float, timing: bool) -> None:
    from pipeline.compare import (
        MeasuredPath,
        blended,
        common_retiming,
        compare_paths,
        markdown_table,
        table_cells,
    )
    from pipeline.compare.metrics import TABLE_HEADER
    from pipeline.refine.measure import measure_path
    from pipeline.route.metric import step_sizes

    steps = step_sizes(results.config.route)
    with messages_console().status("measuring and timing both paths"):
        paths = [blended(results.refinement.coarse, blend_mm * _MM), results.refinement.path] if timing else []
        motions = _motions([(results, path) for path in paths], common_retiming(results.config)) or [None, None]
        coarse, refined = (
            MeasuredPath(measure_path(samples, steps), motion)
            for samples, motion in zip(results.samples, motions, strict=True)
        )
    rows = compare_paths(coarse, refined)
    if as_json:
        typer.echo(json.dumps([asdict(row) for row in rows], indent=2))
    elif markdown:
        typer.echo(markdown_table(rows), nl=False)
    else:
        title = f"{results.config.name}: coarse path against refined path"
        how = f"coarse path timed with its corners rounded by at most {blend_mm:g} mm of actuator travel"
        _print_table(title, TABLE_HEADER, table_cells(rows), how if motions[0] is not None else "")


def _compare_runs(results: "Sequence[Results]", markdown: bool, as_json: bool, timing: bool) -> None:
    from pipeline.compare import common_retiming, compare_runs, runs_cells, runs_header, runs_markdown

    names = _names(results)
    with messages_console().status("measuring and timing all paths"):
        paths = [(one, one.refinement.path) for one in results] if timing else []
        motions = _motions(paths, common_retiming(results[0].config)) or [None] * len(results)
        measured = [_measured(one, results[0], motion) for one, motion in zip(results, motions, strict=True)]
    rows = compare_runs(measured)
    if as_json:
        typer.echo(json.dumps({"runs": names, "rows": [asdict(row) for row in rows]}, indent=2))
    elif markdown:
        typer.echo(runs_markdown(names, rows), nl=False)
    else:
        how = "in brackets: against the first run"
        if timing and any(one.config.machine.limits != results[0].config.machine.limits for one in results):
            how += "; the machines' limits differ, and durations with them"
        _print_table("refined paths of several runs", runs_header(names), runs_cells(names, rows), how)


def _measured(one: "Results", first: "Results", motion: "MotionFigures | None") -> "MeasuredPath":
    """Measure a run's refined path in the metric, with the characteristic length and at the points of the first one."""
    from dataclasses import replace

    import numpy as np

    from pipeline.compare import MeasuredPath
    from pipeline.refine.measure import measure_path, sample_path
    from pipeline.route.metric import step_sizes

    s = np.linspace(0.0, 1.0, first.config.refine.check_points)
    path = one.refinement.path
    machine = replace(path.machine, characteristic_length_m=first.machine.characteristic_length_m)
    samples = sample_path(replace(path, machine=machine), s)
    return MeasuredPath(measure_path(samples, step_sizes(first.config.route)), motion)


def _motions(paths: "Sequence[tuple[Results, Path]]", retiming: "RetimeConfig") -> "list[MotionFigures | None]":
    """Time paths; if one cannot be timed, say so and continue without its figures."""
    from pipeline.compare import measure_motion, retimed

    motions: list[MotionFigures | None] = []
    for results, path in paths:
        try:
            motions.append(measure_motion(retimed(results.config, retiming, path)))
        except NoSolutionError as error:
            messages_console().print(f"{results.config.name}: a path is compared without its duration: {error}")
            motions.append(None)
    return motions


def _names(results: "Sequence[Results]") -> list[str]:
    """Name runs by their configurations, or by their folders if those names are not unique."""
    names = [one.config.name for one in results]
    return names if len(set(names)) == len(names) else [str(one.folder) for one in results]


def _print_table(title: str, header: Sequence[str], cells: Sequence[Sequence[str]], caption: str) -> None:
    table = text_table(title, header, cells, (0, 1, len(header) - 1))
    table.caption, table.caption_justify = caption or None, "left"
    results_console().print(table)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        compare,
        (
            "gantry-tau compare results/agder",
            "gantry-tau compare results/agder --markdown >> notes.md",
            "gantry-tau compare results/agder results/quick",
        ),
    ),
)
"""Every command with its examples."""
