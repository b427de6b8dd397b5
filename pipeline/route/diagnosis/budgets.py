"""How far budgets have to give for a route to exist: positions, mode changes, tilt, travel."""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.config import Config
from pipeline.limits.interface.relaxation import with_values
from pipeline.machine.geometry import Machine
from pipeline.progress import Monitor, Progress
from pipeline.route.bounds.budgets import Budget
from pipeline.route.bounds.shortest_paths import fewest_positions, least_use
from pipeline.route.deadline import Deadline
from pipeline.route.diagnosis.relaxed_table import SearchOutcome, attempted, prefixed, with_little_effort
from pipeline.route.diagnosis.result import Finding, make_finding
from pipeline.route.diagnosis.threshold import FeasibilityThreshold, find_threshold
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.screen import Screen
from pipeline.route.planner import screen_of, solve_problem
from pipeline.route.problem import RouteProblem
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route

MOST_POSITIONS = 500
_STEPS = {"mode_changes": 1.0, "tilt_deg": 0.1, "travel_m": 1e-3}
"""Distance between two values of a budget that are tried."""
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class BudgetSearch:
    """Whole searches that differ in their budgets alone: over the same moves, each followed once for all of them."""

    config: Config
    machine: Machine
    regions: RegionTable
    moves: Moves
    screen: Screen

    @classmethod
    def of(cls, config: Config, machine: Machine, regions: RegionTable, moves: Moves) -> "BudgetSearch":
        """Begin with no move followed; each search has a clock of its own, and what is followed is kept for all."""
        problem = replace(RouteProblem.of(config, machine, regions, moves), deadline=Deadline.after(np.inf))
        return cls(config, machine, regions, moves, screen_of(problem))

    def run(self, config: Config, progress: Progress) -> tuple[Route | None, bool]:
        """Search for a route with other budgets; also return whether a missing one is proven not to exist."""
        monitor = Monitor(progress)
        problem = RouteProblem.of(with_little_effort(config), self.machine, self.regions, self.moves, monitor)
        return attempted(lambda: solve_problem(problem, screen=self.screen)[0])


def relax_step_budget(search: BudgetSearch, progress: Progress) -> Finding:
    """Relax the number of positions: the graph knows the fewest, x and the moves followed may need more."""
    configured = search.config.route.step_budget
    fewest = least_budget(search.config, search.regions, search.moves)
    last = MOST_POSITIONS if fewest is None else min(MOST_POSITIONS, 2 * max(fewest, configured))
    levels = np.arange(configured, last + 1, dtype=float)
    if fewest is None or fewest > last:
        none = FeasibilityThreshold(len(levels) - 1, by_graph=True)
        return make_finding("route.step_budget", configured, levels, none)

    def attempt(index: int) -> SearchOutcome:
        changed = with_values(search.config, "route", step_budget=int(levels[index]))
        found, proven = search.run(changed, prefixed(progress, f"route.step_budget {levels[index]:g}"))
        if found is None:
            return SearchOutcome(None, proven)
        return SearchOutcome(found.objective, enough=len(found) - configured)

    short = max(fewest - configured - 1, 0)
    known = FeasibilityThreshold(short, by_graph=fewest > configured)
    threshold = find_threshold(known, short + 1, len(levels), attempt)
    return make_finding("route.step_budget", configured, levels, threshold)


def least_budget(config: Config, regions: RegionTable, moves: Moves) -> int | None:
    """Count the positions that no route can do with fewer of, be it for the moves or for the distance along X."""
    fewest = fewest_positions(regions, moves)
    distance_m = abs(config.task.goal.x_m - config.task.start.x_m)
    along = int(np.ceil(distance_m / config.route.x_step_m - _ROUNDING))
    return None if fewest is None else max(fewest, along + 1)


def relax_budget(search: BudgetSearch, budget: Budget, progress: Progress) -> Finding:
    """Relax a budget of the task: without it first, then down to the least value with which a route is found."""
    key, step, task = f"task.budget.{budget.key}", _STEPS[budget.key], search.config.task

    def changed(value: float | None) -> Config:
        allowed = int(value) if value is not None and step == 1.0 else value
        return with_values(search.config, "task", budget=task.budget.model_copy(update={budget.key: allowed}))

    configured = float(getattr(task.budget, budget.key))
    free, proven = search.run(changed(None), prefixed(progress, f"without {key}"))
    if free is None:
        # Proven or undecided: no value of the budget is known to help.
        none = FeasibilityThreshold(int(proven), by_graph=False)
        return replace(make_finding(key, configured, np.array([configured, np.inf]), none), removes=True)
    first = int(np.ceil(_least(search, budget) / step - _ROUNDING))
    first = max(first, int(np.floor(configured / step + _ROUNDING)) + 1)
    counts = np.arange(first - 1, max(_level(budget, free), first) + 1)
    levels = np.maximum((counts * step).round(9), configured)
    known = FeasibilityThreshold(0, by_graph=levels[0] > configured, opened=len(levels) - 1, objective=free.objective)

    def attempt(index: int) -> SearchOutcome:
        found, proven = search.run(changed(float(levels[index])), prefixed(progress, f"{key} {levels[index]:g}"))
        if found is None:
            return SearchOutcome(None, proven)
        return SearchOutcome(found.objective, enough=_level(budget, found) - int(counts[0]))

    return make_finding(key, configured, levels, find_threshold(known, 1, len(levels), attempt))


def _least(search: BudgetSearch, budget: Budget) -> float:
    """Compute what every route uses at least over the moves, in the unit of the key."""
    least = least_use(search.regions, search.moves, budget) + budget.limit - budget.left(search.regions)
    return float(np.rad2deg(least)) if budget.in_degrees else least


def _level(budget: Budget, route: Route) -> int:
    """Count the steps of the budget's values that a route uses, rounded up."""
    moved = np.abs(np.diff(route.pose, axis=0)).sum(axis=0)
    tilt_deg = np.rad2deg(moved[[3, 5]].sum())
    used = {"mode_changes": route.mode_changes, "tilt_deg": tilt_deg, "travel_m": moved[:3].sum()}
    return int(np.ceil(float(used[budget.key]) / _STEPS[budget.key] - _ROUNDING))
