"""The command that proves what no continuous path can do."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ConfigArgument, load_task
from pipeline.cli.output import check_output, text_table
from pipeline.cli.reporter import make_reporter
from pipeline.errors import NoSolutionError, UsageError

if TYPE_CHECKING:
    from pipeline.bound.bound import Bound
    from pipeline.config import Config


def bound(
    config: ConfigArgument,
    kappa: Annotated[
        float | None,
        typer.Option("--kappa", min=1.0, max=1e6, help="Prove this K, or nothing. Default: larger and larger ones."),
    ] = None,
    boxes: Annotated[
        int, typer.Option("--boxes", min=1000, max=100_000_000, help="Boxes in all: about 10,000 take a second.")
    ] = 300_000,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="FILE", readable=False, help="Write the proof of the largest K, a tree of boxes."
        ),
    ] = None,
    check: Annotated[
        Path | None, typer.Option("--check", metavar="FILE", help="Verify such a proof again; prove nothing.")
    ] = None,
    run: Annotated[
        Path | None,
        typer.Option(
            "--run", metavar="DIR", help="A run of CONFIG: its path's proven kappa is shown beside the bound."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
) -> None:
    """Prove what no continuous path can do, with no grid.

    Without tilt a theorem may show that every path meets a Type-II
    singularity. For all machines boxes that hold no pose with kappa
    up to K within the limits (travel, strokes, tilts, distances of links)
    may separate start and goal: then every path has a larger kappa. That
    they do not proves nothing. Exits with 1 if K is given and not proven.
    Without --kappa, smaller K use up boxes before larger ones are tried: a
    second run with --kappa proves more with as many boxes.
    With --check, a proof is verified by other code: all it believes of FILE
    is K and how boxes were halved.
    """
    from pipeline.artifacts import json_bytes

    loaded = load_task(config)
    if check is not None:
        if kappa is not None or output is not None or run is not None or as_json:
            raise UsageError("--check FILE excludes other options: K is that of the proof")
        _verify(loaded, check)
        return
    check_output(output)
    path_kappa = None if run is None else _kappa_of(loaded, run)
    found = _bound(loaded, kappa, boxes)
    if output is not None:
        _write(loaded, found, output)
    if as_json:
        typer.echo(json_bytes({**_data(loaded, found), "path_kappa_bound": path_kappa}), nl=False)
    else:
        _show(loaded, found)
        if kappa is None and (advice := what_next(found, boxes)):
            results_console().print(f"For more: {advice}.", soft_wrap=True)
        if path_kappa is not None:
            above = path_kappa / found.least_kappa - 1.0
            results_console().print(
                f"{run}: the certified path has kappa up to {path_kappa:.4g}, {above:.0%} above what is proven of all "
                "paths.",
                soft_wrap=True,
            )
    if kappa is not None and found.kappa is None and not found.theorem.no_path:
        raise NoSolutionError(
            "bound",
            f"kappa {kappa:g} is not proven with {found.attempts[-1].boxes:,} boxes; this does not show a path",
            what_next(found, boxes),
        )


def _bound(config: "Config", kappa: float | None, boxes: int) -> "Bound":
    from pipeline.bound.bound import bound_paths
    from pipeline.machine.geometry import build_machine
    from pipeline.progress import Monitor
    from pipeline.route.regions.endpoints import task_endpoints

    machine = build_machine(config.machine)
    with make_reporter(messages_console(), verbose=False) as reporter:
        monitor = Monitor(reporter.begin("bound"))
        return bound_paths(config, machine, task_endpoints(config, machine), kappa, boxes, monitor)


def what_next(found: "Bound", boxes: int) -> str:
    """Say what may prove more than `boxes` boxes did; nothing where no path exists or every K was proven."""
    from pipeline.bound.flood import Verdict

    if found.theorem.no_path or not found.attempts:
        return ""
    last, spent = found.attempts[-1], sum(one.boxes for one in found.attempts[:-1])
    smaller = f"--kappa between {found.least_kappa:.4g} and {last.kappa:.4g}"
    if last.verdict == Verdict.OPEN:
        return f"try {smaller}; at {last.kappa:.4g} small boxes join start and goal, however many there are"
    if last.verdict == Verdict.NONE and spent + last.boxes < boxes:
        return ""
    if spent:
        ours = f"all {boxes:,} boxes are then for it, of which smaller K took {spent:,}"
        return f"give K by --kappa: {ours}; or raise --boxes"
    return (
        f"raise --boxes, or try {smaller}; the less the platform may tilt (task.tilt_max_deg, task.locked_axes), the "
        "fewer boxes it takes, of paths with such tilts"
    )


def _kappa_of(config: "Config", run: Path) -> float:
    """Read the proven largest kappa of a run's path.

    Raises
    ------
    UsageError
        If the run has no certificate, or is one of another machine or task.
    """
    from pipeline.run.reading import open_results
    from pipeline.stage import Stage

    results = open_results(run, Stage.CERTIFY)
    if results.config.machine != config.machine or results.config.task != config.task:
        raise UsageError(f"{run} is a run of another machine or task.\n  What to change: give a run of this CONFIG.")
    return results.certificate.bounds.kappa


def _write(config: "Config", found: "Bound", output: Path) -> None:
    """Write the proof of the largest K.

    Raises
    ------
    NoSolutionError
        If no flood proved anything.
    """
    from pipeline.artifacts.output import write_output
    from pipeline.artifacts.results.bound import bound_bytes
    from pipeline.bound.tree import proof_codes

    if found.flood is None or found.kappa is None:
        raise NoSolutionError(
            "bound", f"{output} is not written: no flood of boxes proved anything", "give a --kappa, or more --boxes"
        )
    codes = proof_codes(found.flood)
    write_output(output, bound_bytes(config, found.kappa, codes))
    messages_console().print(f"{output}: the proof, a tree of {len(codes):,} boxes", soft_wrap=True)


def _verify(config: "Config", file: Path) -> None:
    """Verify a proof again.

    Raises
    ------
    NoSolutionError
        If it does not hold.
    UsageError
        If the file cannot be used.
    """
    from pipeline.artifacts.results.bound import read_bound
    from pipeline.bound.recheck.verify import verify_bound
    from pipeline.machine.geometry import build_machine
    from pipeline.route.regions.endpoints import task_endpoints

    machine = build_machine(config.machine)
    kappa, codes = read_bound(file, config)
    try:
        found = verify_bound(config, machine, task_endpoints(config, machine), kappa, codes)
    except ValueError as error:
        raise UsageError(f"{file} cannot be read: {error}") from None
    if not found.holds:
        why = f"{found.refuted:,} of {found.wall:,} boxes may hold a path" if found.separated else "start and goal meet"
        raise NoSolutionError("bound", f"{file} does not hold: {why}", "prove the bound again")
    results_console().print(
        f"{file}: verified. Every path within the limits has kappa > {kappa:.6g} somewhere ({found.wall:,} boxes).",
        soft_wrap=True,
    )


def _data(config: "Config", found: "Bound") -> dict[str, object]:
    from pipeline.config.file import config_sha256

    return {
        "name": config.name,
        "config_sha256": config_sha256(config),
        "no_path": found.theorem.no_path,
        "theorem": found.theorem.sentence,
        "ends_kappa": found.ends_kappa,
        "kappa_bound": found.kappa,
        "attempts": [
            {"kappa": one.kappa, "verdict": one.verdict, "boxes": one.boxes, "rounds": one.rounds}
            for one in found.attempts
        ],
    }


def _show(config: "Config", found: "Bound") -> None:
    console = results_console()
    console.print(f"{config.name}: {found.theorem.sentence}.", soft_wrap=True)
    if found.attempts:
        rows = [(f"{one.kappa:.4g}", one.verdict, f"{one.boxes:,}", f"{one.rounds:,}") for one in found.attempts]
        console.print(text_table("paths with kappa <= K", ("K", "verdict", "boxes", "rounds"), rows, (1,)))
    if found.theorem.no_path:
        return
    if found.kappa is None:
        console.print(f"Nothing is proven but that kappa is {found.ends_kappa:.4g} at an end.", soft_wrap=True)
        return
    console.print(
        f"Every path within the limits has kappa > {found.kappa:.4g} somewhere (proven; {found.ends_kappa:.4g} at an "
        "end). A locked axis is meant to be exactly zero.",
        soft_wrap=True,
    )


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        bound,
        (
            "gantry-tau bound configs/agder.yaml    (with task.locked_axes: [rx, rz] a theorem, within a second)",
            "gantry-tau bound CONFIG --kappa 34 --output bound.npz    (with task.locked_axes: [rx], in half a minute)",
            "gantry-tau bound CONFIG --check bound.npz",
        ),
    ),
)
"""Every command with its examples."""
