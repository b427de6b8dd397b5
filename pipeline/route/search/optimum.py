"""Proving an optimum over the admitted moves, by the core or by a program over all regions at once.

The core holds every route of cost at most a threshold, so that its optimum is the optimum when it is at most
the threshold. The threshold starts just above the best bound and is raised until that is so: exact always.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.progress import Progress
from pipeline.route.bounds.budgets import budgets
from pipeline.route.bounds.shortest_paths import Bounds, cheap_moves
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves
from pipeline.route.programs.compact import build_compact_model, read_compact
from pipeline.route.programs.core import build_core
from pipeline.route.programs.core_program import StepSequence, solve_core
from pipeline.route.programs.exclusions import excluded_pairs
from pipeline.route.programs.paper import build_paper_model, read_paper
from pipeline.route.regions.build import RegionTable
from pipeline.solvers.highs import solve_model
from pipeline.status import Status

_GROWTH = 3.0
_ROUNDING = 1e-9
_AHEAD = 1.1
"""Moves are picked for thresholds up to this many times the present one: most of them are too dear for any."""
_SIFTED_AT_ONCE = 20_000
"""Cores of no more arcs are sifted before their threshold is lowered, larger ones only when they are solved."""


Sift = Callable[[Moves, Moves], Moves]
"""Follows the moves of a core, its first argument, and leaves all known to be bad out of its second."""


_NO_MOVES = Moves(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))


def _as_they_are(core: Moves, moves: Moves) -> Moves:
    return moves


@dataclass(frozen=True, eq=False)
class Optimum:
    """A proven optimum over the moves admitted so far.

    Attributes
    ----------
    sequence : StepSequence
        Regions and x of the steps.
    threshold : float
        T of the core it was proven on; infinite for a program over all regions.
    regions : int
        How many regions the program was about.
    """

    sequence: StepSequence
    threshold: float
    regions: int


def find_optimum(
    config: Config,
    regions: RegionTable,
    moves: Moves,
    bounds: Bounds,
    progress: Progress,
    verbose: bool,
    at_least: float = 0.0,
    sift: Sift = _as_they_are,
) -> Optimum | None:
    """Find the route of least sum of kappa with the configured formulation; None: there is no route (proven).

    Parameters
    ----------
    at_least : float
        Known to be no more than the optimum: that of an earlier round with more moves.
    sift : callable
        Leaves bad moves out, asked for every core before it is solved; other formulations do not ask.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends a solve.
    """
    if config.route.formulation == "core":
        return prove_on_core(config, regions, moves, bounds, progress, verbose, at_least, sift)
    return solve_whole(config, regions, moves, progress, verbose)


def solve_whole(
    config: Config, regions: RegionTable, moves: Moves, progress: Progress, verbose: bool
) -> Optimum | None:
    """Solve the paper's or the compact program over all regions: for small grids, and to compare with.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends the solve.
    """
    options = config.route
    build, read = {"paper": (build_paper_model, read_paper), "compact": (build_compact_model, read_compact)}[
        options.formulation
    ]
    steps = step_sizes(options)
    progress(f"route: writing the {options.formulation} program")
    model = build(regions, excluded_pairs(config, regions, moves), steps, options.step_budget, budgets(config))
    outcome = solve_model(model, options.time_limit_s, progress, verbose)
    if outcome.status is Status.INFEASIBLE:
        return None
    if outcome.status is not Status.OPTIMAL:
        raise _unproven(StepSequence(np.empty(0, dtype=np.int64), np.empty(0), outcome, 0), np.inf)
    rows, x = read(outcome.values, regions, options.step_budget)
    length = int(np.argmax(rows == regions.goal)) + 1
    sequence = StepSequence(rows[:length], x[:length], outcome, len(outcome.values))
    return Optimum(sequence, np.inf, len(regions))


def prove_on_core(
    config: Config,
    regions: RegionTable,
    moves: Moves,
    bounds: Bounds,
    progress: Progress,
    verbose: bool,
    at_least: float = 0.0,
    sift: Sift = _as_they_are,
) -> Optimum | None:
    """Raise the threshold until the optimum over the core is at most it, hence optimal; None: there is no route.

    Before a core is solved its moves are sifted; bad ones leave the problem, and the core is laid out again.

    Raises
    ------
    NoSolutionError
        When the solver's time limit ends a solve.
    """
    options = config.route
    # No route within the step budget can cost more than this.
    ceiling = options.step_budget * float(regions.kappa.max())
    margin, known = options.threshold_margin, np.inf
    excluded = max(bounds.optimum, at_least, float(regions.kappa[regions.start]))
    threshold, reach, part = min(excluded * (1.0 + margin), ceiling), -np.inf, moves
    while True:
        if threshold > reach:
            reach = _AHEAD * threshold
            part = sift(_NO_MOVES, cheap_moves(moves, bounds, reach))
        core = build_core(regions, part, bounds, threshold, options.step_budget, options.x_step_m)
        progress(f"route: core of {core.regions:,} regions, {len(core.tail):,} arcs, threshold {threshold:.2f}")
        # The core's own bound minds x and the step budget: a lower threshold may do, and a smaller core.
        lower = core.bound * (1.0 + options.threshold_margin)
        lowered = not core.empty and core.bound > excluded and lower < min(threshold, known)
        if not lowered or len(core.tail) <= _SIFTED_AT_ONCE:
            left = sift(core.moves, part)
            if len(left) < len(part):
                part = left
                continue
        if lowered:
            threshold, margin = lower, options.threshold_margin
            continue
        if not core.empty:
            sequence = solve_core(core, options.time_limit_s, progress, verbose)
            outcome = sequence.outcome
            if outcome.status not in (Status.OPTIMAL, Status.INFEASIBLE):
                raise _unproven(sequence, threshold)
            if outcome.objective <= threshold * (1.0 + _ROUNDING):
                return Optimum(sequence, threshold, core.regions)
            known = min(known, outcome.objective)
        if threshold >= ceiling:
            return None
        excluded = threshold
        margin *= _GROWTH
        threshold = min(excluded * (1.0 + margin), known, ceiling)


def _unproven(sequence: StepSequence, threshold: float) -> NoSolutionError:
    outcome = sequence.outcome
    return NoSolutionError(
        "route",
        f"HiGHS stopped without a proof ({outcome.status}); best sum of kappa {outcome.objective:.3f}, "
        f"bound {outcome.bound:.3f}, threshold {threshold:.3f}",
        outcome.status.advice + " The key is route.time_limit_s.",
        {"status": outcome.status.value, "objective": outcome.objective, "bound": outcome.bound},
    )
