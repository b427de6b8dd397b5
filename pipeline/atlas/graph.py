"""What all routes of an atlas share: regions, moves, and shortest paths from and to every station.

The regions of grid and gates, and the moves between them, are the same for every pair; a pair adds its start, its goal
and their moves. F, the costs of shortest paths from a start, serve for all goals, and B, those to a goal, for all
starts: a pair adds no search of the whole graph, but where budgets or travel along X have a price.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from pipeline.arrays import FloatArray, IntArray
from pipeline.atlas.stations import Station, pair_config
from pipeline.config import Config, PoseConfig
from pipeline.limits.approach import between_approaches
from pipeline.machine.geometry import Machine
from pipeline.machine.rails import with_parallel_rails
from pipeline.progress import QUIET, Monitor
from pipeline.route.bounds.shortest_paths import Bounds, priced_graph
from pipeline.route.cost.objectives import COSTS
from pipeline.route.memory import memory_gb, require_memory
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.endpoints import place_pose
from pipeline.route.regions.table import RegionTable
from pipeline.route.regions.task_rows import endpoint_row, without_obstructions

_KEPT_BYTES = 16
"""Memory of a move between regions that is kept beside those of the pair, and of a distance from and to a station."""


@dataclass(frozen=True, eq=False)
class AtlasGraph:
    """Regions of grid and gates, and how the stations are joined to them.

    Attributes
    ----------
    config, machine : Config, Machine
    stations : tuple of Station
    grid : RegionTable
        Rows of grid and gates only, boxes to avoid cut out.
    moves : Moves
        Between these rows.
    departures, arrivals : sequences of RegionTable
        A row per station: where routes leave from, and where they arrive; they differ with straight ends.
    out, into : sequences of (k,)
        Rows of the grid that can be reached from each station, and those from which it can be.
    direct : (s, s)
        Which stations a single move joins.
    forward, backward : (s, n + 2 s)
        F and B of the rows of grid, departures and arrivals.
    """

    config: Config
    machine: Machine
    stations: tuple[Station, ...]
    grid: RegionTable
    moves: Moves
    departures: Sequence[RegionTable]
    arrivals: Sequence[RegionTable]
    out: Sequence[IntArray]
    into: Sequence[IntArray]
    direct: IntArray
    forward: FloatArray
    backward: FloatArray

    @property
    def station_costs(self) -> FloatArray:
        """Costs of the shortest paths from every station to every other, which no route undercuts. Shape (s, s)."""
        return self.forward[:, len(self.grid) + len(self.stations) :]

    def pair_config(self, pair: tuple[int, int]) -> Config:
        """Give the configuration of the task from one station to another."""
        origin, target = pair
        return pair_config(self.config, self.stations[origin], self.stations[target])

    def regions(self, pair: tuple[int, int]) -> RegionTable:
        """Give the region table of a pair, as `build_regions` does: start and goal are the last two rows."""
        origin, target = pair
        return RegionTable.concatenate([self.grid, self.departures[origin], self.arrivals[target]])

    def problem(self, pair: tuple[int, int], monitor: Monitor = QUIET, *, guided: bool = True) -> RouteProblem:
        """Pose the problem of a pair, whose clock starts now; `guided` as in `RouteProblem`."""
        config, regions = between_approaches(self.pair_config(pair)), self.regions(pair)
        problem = RouteProblem.of(config, self.machine, regions, self._moves(pair), monitor)
        return replace(problem, shortest=self._shortest(pair), guided=guided)

    def _moves(self, pair: tuple[int, int]) -> Moves:
        """Join start and goal to the moves of the grid, sorted by their sources."""
        origin, target = pair
        start, goal = len(self.grid), len(self.grid) + 1
        arriving, leaving = self.into[target], self.out[origin]
        places = np.searchsorted(self.moves.source, arriving, side="right")
        targets = np.append(leaving, goal) if self.direct[origin, target] else leaving
        source = np.insert(self.moves.source, places, arriving)
        return Moves(
            np.append(source, np.full(len(targets), start, dtype=source.dtype)),
            np.append(np.insert(self.moves.target, places, goal), targets.astype(source.dtype)),
        )

    def _shortest(self, pair: tuple[int, int]) -> Bounds:
        origin, target = pair
        n = len(self.grid)
        rows = np.append(np.arange(n), [n + origin, n + len(self.stations) + target])
        return Bounds(self.forward[origin, rows], self.backward[target, rows], start=n)


def build_graph(
    config: Config, machine: Machine, stations: tuple[Station, ...], grid: RegionTable, monitor: Monitor = QUIET
) -> AtlasGraph:
    """Find the moves between all regions and stations, and the shortest paths from and to every station.

    Parameters
    ----------
    grid : RegionTable
        The regions of grid and gates (`grid_regions`).

    Raises
    ------
    NoSolutionError
        When regions, moves and shortest paths would take up more than `route.memory_gb`.
    """
    machine = with_parallel_rails(machine)
    grid = without_obstructions(config, machine, grid)
    departures, arrivals = _ends(config, machine, stations)
    n, count = len(grid), len(stations)
    # The table ends with a start and a goal that nothing is asked of.
    table = RegionTable.concatenate([grid, *departures, *arrivals, departures[0], arrivals[0]])
    moves = _passing_no_station(find_moves(config, machine, table, monitor), n, count)
    needed = 1e9 * memory_gb(len(table), len(moves)) + _KEPT_BYTES * (len(moves) + count * len(table))
    require_memory(config.route, needed, f"regions, moves and {count} stations", "coarsen route.grid")
    monitor.progress("shortest paths from and to every station")
    graph = priced_graph(table, moves, COSTS[config.route.objective](config.route, machine))
    backward = dijkstra(csr_array(graph.T), indices=n + count + np.arange(count))
    inner = (moves.source < n) & (moves.target < n)
    source, target = moves.source[~inner], moves.target[~inner]
    from_grid = source < n
    direct = np.zeros((count, count), dtype=bool)
    both = ~from_grid & (target >= n)
    direct[source[both] - n, target[both] - n - count] = True
    return AtlasGraph(
        config=config,
        machine=machine,
        stations=stations,
        grid=grid,
        moves=moves.take(inner),
        departures=departures,
        arrivals=arrivals,
        out=[target[(source == n + k) & (target < n)] for k in range(count)],
        into=[source[from_grid & (target == n + count + k)] for k in range(count)],
        direct=direct,
        forward=dijkstra(graph, indices=n + np.arange(count))[:, : n + 2 * count],
        backward=backward[:, : n + 2 * count],
    )


def _ends(
    config: Config, machine: Machine, stations: tuple[Station, ...]
) -> tuple[list[RegionTable], list[RegionTable]]:
    """Place the machine where routes leave from every station, and where they arrive there."""

    def rows(pose: Callable[[Config], PoseConfig]) -> list[RegionTable]:
        poses = [pose(between_approaches(pair_config(config, station, station))) for station in stations]
        return [endpoint_row(place_pose(config, machine, "", pose)[0]) for pose in poses]

    return rows(lambda pair: pair.task.start), rows(lambda pair: pair.task.goal)


def _passing_no_station(moves: Moves, n: int, count: int) -> Moves:
    """Keep the moves that leave regions or departures, and reach regions or arrivals, of n regions and `count` each."""
    keep = (moves.source < n + count) & (moves.target < n + 2 * count)
    keep &= (moves.target < n) | (moves.target >= n + count)
    return moves.take(keep)
