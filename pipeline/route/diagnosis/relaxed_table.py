"""The regions and moves of a generous value of one limit, cut down to any other of its values."""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, IntArray
from pipeline.config import Config, RouteConfig
from pipeline.errors import InfeasibleError, NoSolutionError
from pipeline.limits import RegionFilter, Relaxation
from pipeline.limits.interface.relaxation import with_values
from pipeline.machine.geometry import Machine, build_machine
from pipeline.machine.kinematics import follow
from pipeline.machine.rails import with_parallel_rails
from pipeline.machine.samples import PoseSamples
from pipeline.progress import Monitor, Progress
from pipeline.route.bounds.shortest_paths import fewest_positions
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.planner import plan_route
from pipeline.route.regions.build import build_regions
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route

WHY_NOT = "why not: "
_SEARCH_ROUNDS, _SEARCH_S = 30, 30.0
"""Most rounds of a whole search, and its time limit."""
_ROUNDING = 1e-9
_POSES = 33
"""Poses along each move of a route that is looked at once more."""


@dataclass(frozen=True)
class SearchOutcome:
    """How a whole search ended.

    Attributes
    ----------
    objective : float or None
        Cost of the route that was found, None if none was.
    proven : bool
        Whether it is proven that there is none.
    enough : int or None
        The first value that admits all regions of the route that was found.
    obstruction : str
        How what was removed would be in the way of that route.
    """

    objective: float | None
    proven: bool = True
    enough: int | None = None
    obstruction: str = ""


@dataclass(frozen=True, eq=False)
class RelaxedTable:
    """The table and the moves of the mildest of some values of a limit, and the filter for the others."""

    relaxation: Relaxation
    regions: RegionTable
    moves: Moves
    admit: RegionFilter
    options: RouteConfig
    progress: Progress

    @classmethod
    def build(
        cls, machine: Machine, relaxation: Relaxation, end: int, options: RouteConfig, progress: Progress
    ) -> "RelaxedTable":
        """Build regions and moves for the mildest of the first `end` values.

        Raises
        ------
        NoSolutionError
            If they need more memory than allowed, or a visit is out of reach.
        """
        value = float(relaxation.levels[end - 1])
        what = f"without {relaxation.key}" if relaxation.removes else f"{relaxation.key} up to {value:g}"
        tell = prefixed(progress, what)
        wide = relaxation.change(value)
        wide_machine = with_parallel_rails(build_machine(wide.machine))
        regions = build_regions(wide, wide_machine, Monitor(tell))
        moves = find_moves(wide, wide_machine, regions, Monitor(tell))
        admit = relaxation.prepare(regions.samples(machine), regions.x_window_m)
        return cls(relaxation, regions, moves, admit, options, tell)

    def first_joined(self, begin: int, end: int) -> int:
        """Bisect for the first of the values `begin` to `end` - 1 whose graph joins the ends; `end` if none does."""
        if not self.joined(end - 1):
            return end
        return bisect_left(range(end - 1), True, lo=begin, key=self.joined)

    def joined(self, index: int) -> bool:
        """Return whether a value lets the graph join start and goal within the step budget."""
        regions, inside = self.filtered(index)
        i, j = self.moves.source, self.moves.target
        low, high = regions.x_window_m.T
        keep = inside[i] & inside[j]
        keep &= np.maximum(low[i] - high[j], low[j] - high[i]) <= self.options.x_step_m + _ROUNDING
        fewest = fewest_positions(regions, Moves(i[keep], j[keep]))
        return fewest is not None and fewest <= self.options.step_budget

    def filtered(self, index: int) -> tuple[RegionTable, BoolArray]:
        """Return the regions with the x windows that a value leaves, and which of them it admits (n,)."""
        windows, inside = self.admit(float(self.relaxation.levels[index]))
        return replace(self.regions, x_window_m=windows), inside

    def search(self, index: int, run: "WholeSearch") -> SearchOutcome:
        """Search for a route with a value."""
        config = self.relaxation.change(float(self.relaxation.levels[index]))
        regions, inside = self.filtered(index)
        rows = np.flatnonzero(inside)
        machine = with_parallel_rails(build_machine(config.machine))
        found, proven = run(config, machine, regions.take(rows), self.progress)
        if found is None:
            return SearchOutcome(None, proven)
        enough = bisect_left(range(index), True, key=lambda i: bool(self._admits(i, rows[found.region])))
        obstruction = self.relaxation.obstruction(along(machine, found)) if self.relaxation.removes else ""
        return SearchOutcome(found.objective, enough=enough, obstruction=obstruction)

    def _admits(self, index: int, rows: IntArray) -> bool:
        return bool(self.filtered(index)[1][rows].all())


def along(machine: Machine, route: Route) -> PoseSamples:
    """Follow the moves of a route, at some poses of each."""
    share = np.linspace(0.0, 1.0, _POSES)[:, None]
    q = route.q_m[:-1, None] + share * np.diff(route.q_m, axis=0)[:, None]
    pose, _ = follow(machine, q, route.pose[:-1])
    return PoseSamples(machine, pose.reshape(-1, 6), q.reshape(-1, 5))


WholeSearch = Callable[[Config, Machine, RegionTable, Progress], tuple[Route | None, bool]]
"""Searches for a route; also returns whether a missing one is proven not to exist."""


def search_whole(
    config: Config, machine: Machine, regions: RegionTable, progress: Progress, plan: Callable[..., Route] = plan_route
) -> tuple[Route | None, bool]:
    """Run `plan_route` with little effort; also return whether a missing route is proven not to exist."""
    return attempted(lambda: plan(with_little_effort(config), machine, regions, Monitor(progress)))


def with_little_effort(config: Config) -> Config:
    """Ask for any good route: few rounds, a short time, the fastest program."""
    options = config.route
    return with_values(
        config,
        "route",
        formulation="core",
        objective="sum",
        alternative=1,
        max_rounds=min(_SEARCH_ROUNDS, options.max_rounds),
        time_limit_s=min(_SEARCH_S, options.time_limit_s),
    )


def attempted(search: Callable[[], Route]) -> tuple[Route | None, bool]:
    """Run a search; also return whether a missing route is proven not to exist."""
    try:
        return search(), True
    except InfeasibleError:
        return None, True
    except NoSolutionError:
        return None, False


def prefixed(progress: Progress, what: str) -> Progress:
    """Put in front of every message what is being tried."""

    def report(message: str, fraction: float | None = None) -> None:
        inner = message.removeprefix(WHY_NOT).removeprefix("route: ").removeprefix("regions: ")
        progress(f"{WHY_NOT}{what}, {inner}", fraction)

    return report
