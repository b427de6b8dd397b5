"""Commands of an atlas: routes between all pairs of stations, and what is known of a pair."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ConfigArgument, VerboseOption, specs_of
from pipeline.cli.output import check_picture, save_picture, text_table
from pipeline.cli.reporter import make_reporter
from pipeline.errors import NoSolutionError, UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.atlas.record import AtlasRecord, MotionRecord, PairRecord
    from pipeline.config import Config
    from pipeline.run.atlas import AtlasOptions

FolderArgument = Annotated[Path, typer.Argument(metavar="DIR", help="The folder that gantry-tau atlas has written to.")]


def atlas(
    context: typer.Context,
    config: ConfigArgument,
    last: Annotated[
        Stage, typer.Option("--to", help="Stop after this stage, from route on; later ones make a run per pair.")
    ] = Stage.ROUTE,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the atlas. Default: results/<name in CONFIG>-atlas."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Also compute what is up to date.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print atlas.json instead of tables.")] = False,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", readable=False, help="Draw the tables here, too: .png, .pdf, .svg."),
    ] = None,
    verbose: VerboseOption = False,
) -> None:
    """Find the proven best routes between all ordered pairs of stations.

    Stations are the poses of atlas.stations in CONFIG; without any, the
    start, the goal and the poses to visit. Regions and moves are computed
    once. Where nothing depends on the direction of motion, the way back is
    the way there, backwards. Every finished pair is on disk: Ctrl-C loses
    nothing, and the same command goes on. With --to certify or retime every
    proven route becomes a certified motion, in a run folder of its own.

    Exit code 1: a pair is left without a route and without a proof that
    there is none (time limit), or a motion failed.
    """
    if last is Stage.REGIONS:
        raise UsageError("--to regions makes no atlas: allowed are route and later stages")
    check_picture(picture)
    from pipeline.artifacts.layout import ATLAS_PICTURE
    from pipeline.atlas.matrix import matrices
    from pipeline.config.file import load_config, results_folder
    from pipeline.figures.atlas import atlas_figure
    from pipeline.run.atlas import AtlasOptions

    loaded = load_config(config)
    folder = out or results_folder(f"{loaded.name}-atlas")
    record = _made(loaded, folder, AtlasOptions(last, force, specs_of(context)), verbose)
    _show(record, folder, as_json)
    figure = atlas_figure(matrices(record))
    for path in (folder / ATLAS_PICTURE, *(() if picture is None else (picture,))):
        save_picture(figure, path)
        messages_console().print(f"{path}: the tables as a picture", soft_wrap=True)
    if found := record.problems():
        raise _left_open(record, found)


def _made(config: "Config", folder: Path, options: "AtlasOptions", verbose: bool) -> "AtlasRecord":
    from pipeline.progress import Monitor
    from pipeline.run.atlas import make_atlas

    with make_reporter(messages_console(), verbose) as reporter:
        return make_atlas(config, folder, options, Monitor(reporter.begin("atlas"), verbose))


def _left_open(record: "AtlasRecord", found: "list[PairRecord]") -> NoSolutionError:
    first = found[0]
    failure = first if first.motion is None or first.motion.status == "done" else first.motion
    reason = failure.reason or f"the best route found so far is {first.gap or 0.0:.2%} above what is proven"
    return NoSolutionError(
        "atlas",
        f"{len(found)} of {len(record.pairs)} pairs are open; {first.origin} to {first.target}: {reason}",
        failure.advice or "raise route.time_limit_s, and call the same command again: it searches these pairs only",
    )


def atlas_query(
    folder: FolderArgument,
    origin: Annotated[str | None, typer.Argument(metavar="FROM", help="Name of the station to begin at.")] = None,
    target: Annotated[str | None, typer.Argument(metavar="TO", help="Name of the station to end at.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
) -> None:
    """Say what an atlas knows of the way between two stations, or show its tables.

    Nothing is computed. Exit code 1: there is no route, with the reason.
    """
    from pipeline.artifacts import json_bytes
    from pipeline.artifacts.atlas_record import read_atlas

    record = read_atlas(folder)
    if origin is None:
        _show(record, folder, as_json)
        return
    if target is None:
        raise UsageError(f"FROM needs TO: give another station, of {', '.join(record.names)}")
    pair = record.pair(origin, target)
    if as_json:
        typer.echo(json_bytes(pair.model_dump(mode="json")), nl=False)
    elif pair.route:
        for line in _lines(record, pair, folder):
            results_console().print(line, soft_wrap=True)
    if not pair.route:
        raise NoSolutionError(
            "atlas", f"{origin} to {target} is {pair.status}: {pair.reason}", pair.advice or "nothing"
        )


def _lines(record: "AtlasRecord", pair: "PairRecord", folder: Path) -> list[str]:
    """Describe the route of a pair, and its motion if there is one."""
    from pipeline.summary.objective_words import ROUTE_QUANTITIES

    quantity = ROUTE_QUANTITIES[record.objective_kind]
    assert pair.objective is not None
    backwards = f", that of {pair.target} to {pair.origin} backwards" if pair.from_reverse else ""
    lines = [
        f"{pair.origin} to {pair.target}: {pair.status}{backwards}",
        f"  {quantity.name} {quantity.shown(pair.objective, 3)} (gap {pair.gap or 0.0:.2%}), {pair.steps} positions, "
        f"{pair.mode_changes} mode changes, largest kappa {pair.kappa_max:.2f}",
        f"  {' '.join(pair.modes)}",
        f"  {folder / pair.route}",
    ]
    return lines if pair.motion is None else [*lines, *_motion_lines(pair.motion, folder)]


def _motion_lines(motion: "MotionRecord", folder: Path) -> list[str]:
    run = f"  {folder / motion.run}{', backwards' if motion.backwards else ''}"
    if motion.status != "done":
        return [f"  {motion.to} failed: {motion.reason}", run]
    known = [
        (motion.kappa_integral, "path: kappa integral {:.1f}"),
        (motion.kappa_max, "largest kappa {:.2f}"),
        (motion.kappa_bound, "proven at most {:.2f}"),
        (motion.duration_s, "duration {:.3f} s"),
    ]
    return ["  " + ", ".join(text.format(value) for value, text in known if value is not None), run]


def _show(record: "AtlasRecord", folder: Path, as_json: bool) -> None:
    from pipeline.artifacts import json_bytes
    from pipeline.atlas.matrix import matrices

    if as_json:
        typer.echo(json_bytes(record.model_dump(mode="json")), nl=False)
        return
    console = results_console()
    for matrix in matrices(record):
        rows = ([name, *texts] for name, texts in zip(matrix.names, matrix.texts, strict=True))
        console.print(text_table(f"{record.name}, {matrix.title}", ("from \\ to", *matrix.names), rows))
    searched = sum(not pair.from_reverse for pair in record.pairs)
    console.print(
        f"{len(record.pairs)} pairs of {len(record.names)} stations, {searched} of them searched. "
        f"Next: gantry-tau atlas-query {folder} {' '.join(record.names[:2])}",
        soft_wrap=True,
    )


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        atlas,
        (
            "gantry-tau atlas configs/quick.yaml",
            "gantry-tau atlas configs/cell.yaml --to retime --out cell-atlas",
            "gantry-tau atlas configs/cell.yaml --json --picture atlas.pdf",
        ),
    ),
    (
        atlas_query,
        (
            "gantry-tau atlas-query results/quick-atlas start goal",
            "gantry-tau atlas-query results/quick-atlas goal start --json",
            "gantry-tau atlas-query results/quick-atlas",
        ),
    ),
)
"""Every command with its examples."""
