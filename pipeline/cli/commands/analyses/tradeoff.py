"""The command that trades duration off against kappa."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ConfigArgument, VerboseOption, load_task
from pipeline.cli.output import check_picture, save_picture, text_table
from pipeline.errors import UsageError

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.tradeoff import Tradeoff

_LARGEST = 1_000.0


def tradeoff(
    config: ConfigArgument,
    weights: Annotated[
        list[str],
        typer.Option("--weights", metavar="W,W,...", help="Weights of the integral of kappa: less is faster."),
    ] = ["10,3,1,0.3,0.1"],  # noqa: B006  # typer copies it
    routes: Annotated[
        int, typer.Option("--routes", metavar="K", min=1, max=10, help="The K best routes, a curve each.")
    ] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", readable=False, help="Draw the curves: .png, .pdf or .svg."),
    ] = None,
    verbose: VerboseOption = False,
) -> None:
    """Trade duration off against kappa: a motion for every weight, each of them certified.

    Path and time law are found together, as with refine.objective: time;
    every weight is a refine.time_weight, and refine.kappa_max of CONFIG is
    the cap. "No time" is the path of least integral of kappa. Other routes
    have other working modes: the fastest is often not the first. Takes
    about a quarter of a minute for every point. Nothing is written but the
    picture.
    """
    chosen = _weights(",".join(weights))
    check_picture(picture)
    loaded = load_task(config)
    found = _trade_off(loaded, chosen, routes, verbose)
    _show(loaded, found, as_json)
    if picture is not None and found.points:
        from pipeline.figures.tradeoff import tradeoff_figure

        save_picture(tradeoff_figure(found.points), picture)
        messages_console().print(f"{picture}: duration over the integral and the largest kappa", soft_wrap=True)
    if found.missing:
        raise found.missing[0].error


def _weights(text: str) -> tuple[float, ...]:
    """Read weights, without duplicates, the largest first.

    Raises
    ------
    UsageError
        When one is not a number, or not one that refine.time_weight may be.
    """
    try:
        values = {float(part) for part in text.split(",")}
    except ValueError:
        raise UsageError(f"--weights {text}: expected numbers with commas between them, such as 3,1,0.3") from None
    if wrong := [value for value in values if not 0.0 < value <= _LARGEST]:
        raise UsageError(f"--weights: {wrong[0]:g} is not allowed; allowed is anything above 0, at most {_LARGEST:g}")
    return tuple(sorted(values, reverse=True))


def _trade_off(config: "Config", weights: tuple[float, ...], routes: int, verbose: bool) -> "Tradeoff":
    from pipeline.machine.geometry import build_machine
    from pipeline.progress import Monitor
    from pipeline.tradeoff import trade_off

    with messages_console().status("trading duration off against kappa") as status:

        def progress(message: str, fraction: float | None = None) -> None:
            status.update(message)

        return trade_off(config, build_machine(config.machine), weights, routes, Monitor(progress, verbose))


def _show(config: "Config", found: "Tradeoff", as_json: bool) -> None:
    from pipeline.artifacts import json_bytes
    from pipeline.tradeoff import TABLE_HEADER, missing_text, table_cells, tradeoff_data

    if as_json:
        typer.echo(json_bytes(tradeoff_data(config, found)), nl=False)
    elif found.points:
        title = f"{config.name}: duration against kappa, every motion certified"
        cells, words = table_cells(found.points), (len(TABLE_HEADER) - 1,)
        results_console().print(text_table(title, TABLE_HEADER, cells, words))
    for missing in found.missing:
        messages_console().print(missing_text(missing), soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        tradeoff,
        (
            "gantry-tau tradeoff configs/agder.yaml --picture tradeoff.png",
            "gantry-tau tradeoff configs/quick.yaml --routes 3 --weights 3,1,0.3 --json",
        ),
    ),
)
"""Every command with its examples."""
