"""What is best: the least sum of kappa (5), or the least largest kappa and then the least sum."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.config import Config
from pipeline.progress import Progress
from pipeline.route.bounds.bottleneck import least_cap, moves_within
from pipeline.route.bounds.budget_prices import priced_bounds
from pipeline.route.bounds.budgets import budgets
from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.screen import Screen
from pipeline.route.programs.core_program import StepSequence
from pipeline.route.search.optimum import Optimum, find_optimum
from pipeline.route.search.states import StateGraph


@dataclass(frozen=True, eq=False)
class Best:
    """A proven optimum over the moves admitted so far.

    Attributes
    ----------
    optimum : Optimum
        Of the sum of kappa.
    cap : float
        What kappa was limited to: the least that leaves a route, infinite when the sum alone counts.
    relaxation : float
        Bound on the sum when x and the step budget are left out.
    """

    optimum: Optimum
    cap: float
    relaxation: float

    def sequence(self, layout: StateGraph) -> StepSequence:
        """The solution with rows of the region table."""
        sequence = self.optimum.sequence
        return replace(sequence, region=layout.base[sequence.region])


def find_best(
    config: Config,
    layout: StateGraph,
    bounds: Bounds,
    screen: Screen,
    before: Best | None,
    progress: Progress,
    verbose: bool,
) -> Best | None:
    """Find the best sequence over the moves not known to be bad; None: there is none (proven).

    `bounds` are those of the layout, `before` is the best of the round before, with more moves.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends a solve.
    """

    def solve(moves: Moves, cap: float, known: Bounds) -> Best | None:
        at_least = before.optimum.sequence.outcome.objective if before and before.cap >= cap else 0.0
        optimum = find_optimum(config, layout.regions, moves, known, progress, verbose, at_least, sift)
        return None if optimum is None else Best(optimum, cap, known.optimum)

    def sift(core: Moves, moves: Moves) -> Moves:
        return screen.screen(core, moves, layout.base)

    def solve_capped(cap: float) -> Best | None:
        moves = moves_within(screen.without_bad(layout.moves, layout.base), layout.regions.kappa, cap)
        known = priced_bounds(layout.regions, moves, budgets(config), progress)
        return solve(moves, cap, known) if np.isfinite(known.optimum) else None

    if config.route.objective == "sum":
        return solve(screen.without_bad(layout.moves, layout.base), np.inf, bounds)
    return _least_largest(config, layout, screen, before, solve_capped, progress)


def _least_largest(
    config: Config,
    layout: StateGraph,
    screen: Screen,
    before: Best | None,
    solve: Callable[[float], Best | None],
    progress: Progress,
) -> Best | None:
    """Find the least cap on kappa with which there is a sequence: the graph's own, or above it by bisection.

    The graph knows nothing of x and budgets, and core after core forbids moves; each solve then tells.
    """
    kappa = layout.regions.kappa
    progress("route: least largest kappa")
    moves = screen.without_bad(layout.moves, layout.base)
    least = least_cap(layout.regions, moves, most_moves=config.route.step_budget - 1, budgets=budgets(config))
    least = max(least, before.cap if before else 0.0)
    if not np.isfinite(least) or (best := solve(least)) is not None:
        return best if np.isfinite(least) else None
    if (best := solve(float(kappa.max()))) is None:
        return None
    caps = np.unique(kappa[kappa > least])
    low, high = -1, int(np.searchsorted(caps, _largest(best, kappa)))
    while high - low > 1:
        middle = (low + high) // 2
        progress(f"route: least largest kappa, between {caps[max(low, 0)]:.3f} and {caps[high]:.3f}")
        if (found := solve(float(caps[middle]))) is None:
            low = middle
        else:
            high, best = int(np.searchsorted(caps, _largest(found, kappa))), found
    # A best under a larger cap that does not exceed this one is the best under this one, too.
    return replace(best, cap=float(caps[high]))


def _largest(best: Best, kappa: np.ndarray) -> float:
    return float(kappa[best.optimum.sequence.region].max())
