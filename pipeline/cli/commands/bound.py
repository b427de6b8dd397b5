"""The command that proves what no continuous path can do."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ConfigArgument, load_task
from pipeline.cli.output import text_table

if TYPE_CHECKING:
    from pipeline.bound.bound import Bound
    from pipeline.config import Config


def bound(
    config: ConfigArgument,
    kappa: Annotated[
        float | None,
        typer.Option(
            "--kappa", min=1.0, max=1e6, help="Prove this K, or nothing. Default: larger and larger ones by 10 %."
        ),
    ] = None,
    boxes: Annotated[
        int, typer.Option("--boxes", min=1000, max=100_000_000, help="Boxes in all: about 20,000 take a second.")
    ] = 300_000,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
) -> None:
    """Prove what no continuous path can do, with no grid.

    Without tilt a theorem may show that every path meets a Type-II
    singularity. For all machines boxes that hold no pose with kappa
    up to K within the limits (travel, strokes, tilts, distances of links)
    may separate start and goal: then every path has a larger kappa. That
    they do not proves nothing. Exits with 1 if K is given and not proven.
    """
    from pipeline.artifacts import json_bytes

    loaded = load_task(config)
    found = _bound(loaded, kappa, boxes)
    if as_json:
        typer.echo(json_bytes(_data(loaded, found)), nl=False)
    else:
        _show(loaded, found)
    if kappa is not None and found.kappa is None and not found.theorem.no_path:
        from pipeline.errors import NoSolutionError

        raise NoSolutionError(
            "bound",
            f"kappa {kappa:g} is not proven with {found.attempts[-1].boxes:,} boxes; this does not show a path",
            "raise --boxes, or lower --kappa",
        )


def _bound(config: "Config", kappa: float | None, boxes: int) -> "Bound":
    from pipeline.bound.bound import bound_paths
    from pipeline.machine.geometry import build_machine
    from pipeline.progress import Monitor
    from pipeline.route.regions.endpoints import task_endpoints

    machine = build_machine(config.machine)
    with messages_console().status("bounding kappa") as status:

        def progress(message: str, fraction: float | None = None) -> None:
            status.update(message)

        return bound_paths(config, machine, task_endpoints(config, machine), kappa, boxes, Monitor(progress))


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
            "gantry-tau bound configs/agder.yaml --kappa 23.5 --boxes 2000000",
        ),
    ),
)
"""Every command with its examples."""
