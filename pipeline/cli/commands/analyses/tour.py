"""The command that drives a tour: certified motions through many poses, and back."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import ConfigArgument, VerboseOption, specs_of
from pipeline.cli.output import text_table
from pipeline.cli.reporter import make_reporter
from pipeline.errors import NoSolutionError

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.run.tour import StopTable, Tour, TourOptions

_HEADER = ("leg", "to", "mode", "largest kappa", "proven at most", "arrives s", "leaves s", "certificate")


def tour(
    context: typer.Context,
    config_file: ConfigArgument,
    poses: Annotated[
        Path, typer.Argument(metavar="POSES", help="CSV file of poses, as calibrate --next-output writes it.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the tour. Default: results/<name in CONFIG>-tour."),
    ] = None,
    most: Annotated[
        int | None,
        typer.Option(
            "--most",
            metavar="N",
            min=1,
            max=200,
            help="Visit so many poses; later rows take the place of those that cannot be reached. Default: all rows.",
        ),
    ] = None,
    dwell_s: Annotated[
        float, typer.Option("--dwell-s", metavar="S", min=0.0, max=3600.0, help="How long to stand at every pose.")
    ] = 5.0,
    leg_s: Annotated[
        float,
        typer.Option("--leg-s", metavar="S", min=0.1, max=1e6, help="Time for the search of the route of each leg."),
    ] = 20.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print tour.json instead of a table.")] = False,
    verbose: VerboseOption = False,
) -> None:
    """Drive through many poses, from task.start and back: a certified motion for each leg, and all in one file.

    POSES has q1_m to q5_m and x_m to rz_rad in a row per pose; the carts'
    q1_m to q3_m tell the working mode. They are visited in a short order, by
    routes that are the best found in --leg-s seconds, and the same path,
    certificate and trajectory as of a run. A pose that cannot be reached is
    left out, with the reason.

    DIR gets tour.csv, the whole motion as trajectory.csv would have it;
    poses.csv, the poses in their order with blanks for the tracker and the
    times at which the machine stands there; tour.json, what is proven of
    every leg; and a run folder per leg, for exports and reports. Finished
    legs are on disk: Ctrl-C loses nothing, and the same command goes on.

    Exit code 1: no pose can be reached, or there is no way back.
    """
    from pipeline.config.file import load_config, results_folder
    from pipeline.run.tour import TourOptions, read_stops

    config = load_config(config_file)
    table = read_stops(poses, config)
    folder = out or results_folder(f"{config.name}-tour")
    made = _made(config, table, folder, TourOptions(most, dwell_s, leg_s, specs_of(context)), verbose)
    _show(folder, as_json)
    for name, reason in made.left_out.items():
        messages_console().print(f"{name} is left out: {reason}", soft_wrap=True)
    if made.no_return:
        raise NoSolutionError(
            "tour",
            made.no_return,
            "drive the legs backwards, by their trajectory_back.csv in the opposite order; or leave that pose out",
        )


def _made(config: "Config", table: "StopTable", folder: Path, options: "TourOptions", verbose: bool) -> "Tour":
    from pipeline.progress import Monitor
    from pipeline.run.tour import make_tour

    with make_reporter(messages_console(), verbose) as reporter:
        return make_tour(config, table, folder, options, Monitor(reporter.begin("tour"), verbose))


def _show(folder: Path, as_json: bool) -> None:
    from pipeline.artifacts.layout import TOUR_CSV, TOUR_JSON, TOUR_POSES
    from pipeline.artifacts.tour import read_tour

    data = read_tour(folder)
    if as_json:
        typer.echo((folder / TOUR_JSON).read_text(), nl=False)
    else:
        results_console().print(text_table("tour", _HEADER, map(_cells, range(1, 201), data["legs"]), (1, 2, 7)))
    count, seconds = data["poses"], f"{data['duration_s']:.0f} s, {data['dwell_s']:g} s at each"
    messages_console().print(
        f"{folder / TOUR_CSV}: {count} pose{'s'[: count != 1]} in {seconds}; "
        f"{folder / TOUR_POSES}: the poses to be filled in",
        soft_wrap=True,
    )


def _cells(number: int, leg: dict[str, Any]) -> tuple[str, ...]:
    bound = leg["kappa_bound"]
    return (
        f"{number}",
        leg["to"],
        leg["mode"],
        f"{leg['kappa_max']:.1f}",
        "-" if bound is None else f"{bound:.1f}",
        f"{leg['arrives_s']:.1f}",
        f"{leg['end_s']:.1f}",
        leg["verdict"],
    )


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        tour,
        (
            "gantry-tau tour cell.yaml first.csv",
            "gantry-tau tour real.yaml then.csv --most 12 --dwell-s 8 --out tour",
        ),
    ),
)
"""The command with its examples."""
