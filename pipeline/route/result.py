"""The result of stage one: a route, and the figures that say how good it is and how it was found."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config.choices import RouteObjective
from pipeline.machine.geometry import MODES
from pipeline.status import Status


@dataclass(frozen=True)
class Search:
    """How the route was found, and what is proven of it.

    Attributes
    ----------
    solver : str
        What found it: name and version of the mixed-integer solver, or label setting.
    bound, gap : float
        Proven lower bound on the objective, and the relative distance of the objective to it.
    relaxation : float
        Cost of the shortest path when x and the step budget are left out.
    threshold : float
        The last core held every route of at most this cost; the proof needs objective <= threshold.
    core_regions, core_columns : int
        Size of the last core: regions, and columns of the mixed-integer program, or arcs where labels were set.
    moves : int
        Number of admitted moves between regions.
    rounds : int
        Number of times the problem was solved.
    followed_moves : int
        Number of moves followed continuously: all those of a core before it was solved.
    forbidden_moves : int
        Number of moves that were inadmissible when followed continuously.
    least_kappa_max : float
        The least largest kappa of regions that any admitted moves from start to goal go through, to one per cent, which
        guides stage two; only moves of a core are followed, so that there need not be such a route.
    """

    solver: str
    bound: float
    gap: float
    relaxation: float
    threshold: float
    core_regions: int
    core_columns: int
    moves: int
    rounds: int
    followed_moves: int
    forbidden_moves: int
    least_kappa_max: float


@dataclass(frozen=True, eq=False)
class Route:
    """A sequence of regions from start to goal; every move was followed continuously and found admissible.

    Attributes
    ----------
    region : (n,)
        Row of the region table.
    modes, gates : (n,)
        Working mode (0 to 7); arm (1 to 3) whose gate the region is, 0 for none.
    visits : (n,)
        Entry of `task.visit` that is visited there, counted from 1; 0 for none.
    pose : (n, 6)
        x, y, z, rx, ry, rz.
    q_m : (n, 5)
        Actuator positions.
    kappa : (n,)
        Condition number.
    objective : float
        What `objective_kind` adds up: the integral of kappa along the moves, the sum of kappa over all regions but
        the goal (5), or the time of the moves (s).
    status : Status
        OPTIMAL: proven over the admitted moves; UNPROVEN: the best one found in `route.time_limit_s`.
    search : Search
        How it was found.
    objective_kind : RouteObjective
        What it was the best of.
    """

    region: IntArray
    modes: IntArray
    gates: IntArray
    visits: IntArray
    pose: FloatArray
    q_m: FloatArray
    kappa: FloatArray
    objective: float
    status: Status
    search: Search
    objective_kind: RouteObjective = RouteObjective.SUM

    def __len__(self) -> int:
        return len(self.region)

    @property
    def mode_names(self) -> list[str]:
        """Working mode of every step, LLL to RRR."""
        return [MODES[mode] for mode in self.modes]

    @property
    def kappa_max(self) -> float:
        """Largest kappa of the regions visited."""
        return float(self.kappa.max())

    @property
    def mode_changes(self) -> int:
        """Number of changes of an arm's working mode along the route."""
        changed = np.bitwise_xor(self.modes[1:], self.modes[:-1])
        return int(sum(int(bits).bit_count() for bits in changed))
