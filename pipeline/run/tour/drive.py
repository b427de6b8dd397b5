"""A tour through many poses: in which order, leg by leg, and what becomes of poses that are not reached.

Regions, moves and shortest paths are the same for all legs. The order is that of least cost along shortest paths. A
pose that cannot be reached is left out, and one of those beyond the number wanted takes its place.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.artifacts.tour import open_tour_folder
from pipeline.atlas.graph import AtlasGraph, build_graph
from pipeline.atlas.stations import Station, require_stations
from pipeline.atlas.tour import tour_order
from pipeline.config import Config
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine.geometry import build_machine
from pipeline.progress import QUIET, Monitor
from pipeline.route import grid_regions
from pipeline.route.regions.size import require_grid_fits
from pipeline.run.makers.grid_cache import cached_grid
from pipeline.run.results import Results
from pipeline.run.stage_specs import SPECS, Specs
from pipeline.run.tour.files import tour_files
from pipeline.run.tour.legs import Leg, LegMaker
from pipeline.run.tour.result import Tour
from pipeline.run.tour.stops import StopTable

_APART = "no moves of the grid join it with task.start"
Make = Callable[[int, int, Monitor], Leg]
_HOME = 0
"""Number of the station where the machine stands first, and is brought back to."""


@dataclass(frozen=True)
class TourOptions:
    """How a tour is driven.

    Attributes
    ----------
    most : int or None
        How many poses are visited; those beyond take the place of what cannot be reached. None: all.
    dwell_s : float
        How long the machine stands at every pose.
    leg_s : float
        Time for the search of the route of a leg: the best one found then is driven, whether proven optimal or not.
    specs : tuple of StageSpec
        The stages of the runs.
    """

    most: int | None = None
    dwell_s: float = 5.0
    leg_s: float = 20.0
    specs: Specs = SPECS


def make_tour(
    config: Config, table: StopTable, out: Path, options: TourOptions = TourOptions(), monitor: Monitor = QUIET
) -> Tour:
    """Drive from `task.start` through the poses of a table and back, into the folder `out`.

    Every finished leg is on disk; the same call goes on where an interrupted one ended.

    Raises
    ------
    ConfigError
        When the machine cannot be at task.start, or the grid takes up more memory than allowed.
    UsageError
        When another process is writing to the folder, or it is not one of a tour.
    NoSolutionError
        When none of the poses can be reached, or what all legs share takes up more memory than allowed.
    """
    left_out: dict[str, str] = {}
    config = config.model_copy(update={"route": config.route.model_copy(update={"alternative": 1})})
    require_grid_fits(config)
    machine = build_machine(config.machine)
    home = Station("start", config.task.start, "task.start")
    require_stations(config, machine, (home,))
    stations = [home]
    for station in table.stations:
        try:
            require_stations(config, machine, (station,))
            stations.append(station)
        except ConfigError as error:
            left_out[station.name] = "; ".join(f"it {issue.message}" for issue in error.issues)
    with open_tour_folder(out) as folder:
        results = Results(config, machine, folder.path)
        grid = cached_grid(results, monitor, lambda: grid_regions(config, machine, monitor))
        graph = build_graph(_hasty(config, options.leg_s), machine, tuple(stations), grid, monitor)
        maker = LegMaker(config, graph, folder, options.dwell_s, options.specs)
        tour = drive(graph, maker.make, options.most, left_out, monitor)
        if not tour.legs:
            raise NoSolutionError("tour", _none_reached(left_out), "Give other poses, or a finer grid (route.grid).")
        folder.write(tour_files(config, table, tour, options.dwell_s))
    return tour


def _hasty(config: Config, leg_s: float) -> Config:
    """Let the search of a route take so long."""
    return config.model_copy(update={"route": config.route.model_copy(update={"time_limit_s": leg_s})})


def drive(graph: AtlasGraph, make: Make, most: int | None, left_out: dict[str, str], monitor: Monitor = QUIET) -> Tour:
    """Make leg after leg to so many stations of a graph, and the one back.

    Parameters
    ----------
    make : callable
        Makes the leg between two stations, as `LegMaker.make`.
    left_out : dict
        Poses that are left out already, and why.
    """
    names, costs = [station.name for station in graph.stations], graph.station_costs
    both = np.isfinite(costs[_HOME]) & np.isfinite(costs[:, _HOME])
    reached = [k for k in range(1, len(names)) if both[k]]
    left_out = left_out | {names[k]: _APART for k in range(1, len(names)) if not both[k]}
    wanted, spare = reached[:most], reached[len(reached[:most]) :]
    legs: list[Leg] = []
    at, ahead = _HOME, tour_order(costs, _HOME, wanted, _HOME)
    while ahead:
        target, *ahead = ahead
        try:
            legs.append(make(at, target, _counting(monitor, len(legs), len(legs) + len(ahead) + 2)))
            at = target
        except NoSolutionError as error:
            left_out[names[target]] = f"no way there from {names[at]}; {error.reason}"
            if spare:
                ahead = tour_order(costs, at, [*ahead, spare.pop(0)], _HOME)
    no_return = ""
    if legs:
        try:
            legs.append(make(at, _HOME, _counting(monitor, len(legs), len(legs) + 1)))
        except NoSolutionError as error:
            no_return = f"no way back from {names[at]}; {error.reason}"
    return Tour(graph.stations, tuple(legs), left_out, no_return)


def _counting(monitor: Monitor, done: int, total: int) -> Monitor:
    """Let a monitor say which leg is made."""

    def progress(message: str, fraction: float | None = None) -> None:
        monitor.progress(f"leg {done + 1} of {total}, {message}", done / total)

    return Monitor(progress, monitor.verbose)


def _none_reached(left_out: dict[str, str]) -> str:
    name, reason = next(iter(left_out.items()))
    return f"none of {len(left_out)} poses can be reached; {name}: {reason}"
