"""A leg of a tour: a certified motion between two stations, by the ordinary stages, in a run folder of its own."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.artifacts.tour import TourFolder
from pipeline.atlas.graph import AtlasGraph
from pipeline.atlas.plan import plan_pairs
from pipeline.atlas.stations import pair_config
from pipeline.config import Config
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.progress import Monitor
from pipeline.route.result import Route
from pipeline.run.execute import run_pipeline
from pipeline.run.options import RunOptions
from pipeline.run.reporter import NamedReporter, failure_of
from pipeline.run.stage_specs import Specs
from pipeline.stage import Stage
from pipeline.status import Status


@dataclass(frozen=True)
class Leg:
    """A motion of a tour.

    Attributes
    ----------
    origin, target : int
        Numbers of the stations; 0 is where the machine stands first.
    run : Path
        The folder of its run.
    summary : dict
        Its summary.
    """

    origin: int
    target: int
    run: Path
    summary: dict[str, Any]


class LegMaker:
    """Makes the legs of a tour; those that are on disk and up to date are taken from there.

    Parameters
    ----------
    config : Config
        That of all legs, as their runs keep it: how long the graph lets a search take does not outdate what was found.
    dwell_s : float
        How long the machine stands at the end of a leg, but for the one back to station 0.
    """

    def __init__(self, config: Config, graph: AtlasGraph, folder: TourFolder, dwell_s: float, specs: Specs) -> None:
        self._config = config
        self._graph = graph
        self._folder = folder
        self._dwell_s = dwell_s
        self._specs = specs

    def make(self, origin: int, target: int, monitor: Monitor) -> Leg:
        """Make a leg.

        Raises
        ------
        NoSolutionError
            When there is none; the reason begins with the stage that failed.
        """
        pair = origin, target
        ends = [self._graph.stations[k] for k in pair]
        config, names = pair_config(self._config, *ends), [station.name for station in ends]
        waits = (0.0, self._dwell_s if target else 0.0)
        config = config.model_copy(update={"retime": config.retime.model_copy(update={"dwell_s": waits})})
        given: dict[Stage, Callable[[], Any]] = {
            Stage.REGIONS: lambda: self._graph.regions(pair),
            Stage.ROUTE: lambda: self._route(pair, monitor),
        }
        options = RunOptions(last=Stage.RETIME, why_not=False, unproven=True, verbose=monitor.verbose)
        reporter = NamedReporter(" to ".join(names), monitor.progress)
        run = self._folder.leg("--".join(names))
        try:
            report = run_pipeline(config, run, options, reporter, self._specs, given)
        except (ConfigError, NoSolutionError) as error:
            stage, reason, advice = failure_of(error)
            raise NoSolutionError("tour", f"{stage or 'task'}: {reason}", advice or "nothing") from None
        return Leg(origin, target, run, report.summary)

    def _route(self, pair: tuple[int, int], monitor: Monitor) -> Route:
        entry = next(iter(plan_pairs(self._graph, [pair], {}, monitor)))
        if entry.route is None:
            more = "; --leg-s gives it more time" if entry.status == Status.TIME_LIMIT else ""
            raise NoSolutionError("route", entry.reason + more, entry.advice)
        return entry.route
