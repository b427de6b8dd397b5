"""From a sequence of regions to a route: x for every step, poses, actuator positions, and a check of all rules."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import NoSolutionError
from pipeline.route.cost.objectives import route_cost
from pipeline.route.moves.check import check_moves
from pipeline.route.moves.rejections import Rejection
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.solution import StepSequence
from pipeline.route.regions.table import RegionTable
from pipeline.route.search.gate_modes import fewest_mode_changes
from pipeline.route.search.rule_check import rule_violations, task_violations
from pipeline.route.search.x_positions import smoothest_x
from pipeline.status import Status

ChooseX = Callable[[FloatArray, float, float, FloatArray], FloatArray]
"""Chooses x (n,): windows (n, 2), largest move per step, time limit, and an x (n,) known to be feasible."""


@dataclass(frozen=True, eq=False)
class PlacedRoute:
    """A sequence of regions with its x: rows of the table, columns as in `Route`."""

    region: IntArray
    steps: RegionTable
    pose: FloatArray
    q_m: FloatArray
    objective: float

    @property
    def visits(self) -> IntArray:
        """The visit made at each step, in their order; passing a place that was visited before is not one."""
        visits = np.zeros(len(self.region), dtype=np.int64)
        for step, stop in enumerate(self.steps.visits.tolist()):
            if stop == visits.max() + 1:
                visits[step] = stop
        return visits


def place_route(problem: RouteProblem, sequence: StepSequence, choose_x: ChooseX = smoothest_x) -> PlacedRoute:
    """Turn a sequence of regions into poses and actuator positions, with the fewest mode changes and the smoothest x.

    Raises
    ------
    NoSolutionError
        When the sequence breaks a rule of the paper or a budget: nothing a solver returns is taken on trust.
    """
    rows = fewest_mode_changes(problem.regions, sequence.region)
    steps = problem.regions.take(rows)
    options = problem.options
    x = sequence.x_m
    if not problem.cost.counts_x:
        x = choose_x(steps.x_window_m, options.x_step_m, options.time_limit_s, x)
    if _broken_rules(problem, rows, x):
        # The smoothest x is only known to the tolerance of its program, which a tight budget may not allow for.
        x = sequence.x_m
    if broken := _broken_rules(problem, rows, x):
        raise NoSolutionError(
            "route",
            f"the solver returned a sequence that breaks the rules: {'; '.join(broken)}",
            "this is a numerical failure: change route.grid or route.x_step_m a little",
            {"status": Status.NOT_CONVERGED.value, "broken": broken},
        )
    q, pose = steps.q_m.copy(), steps.pose
    q[:, :3] += (x - pose[:, 0])[:, None]
    pose[:, 0] = x
    return PlacedRoute(rows, steps, pose, q, route_cost(problem.cost, problem.regions, rows, x))


def _broken_rules(problem: RouteProblem, rows: IntArray, x_m: FloatArray) -> list[str]:
    of_the_paper = rule_violations(problem.regions, rows, x_m, problem.steps, problem.options.step_budget)
    return of_the_paper + task_violations(problem.config, problem.regions, rows, x_m)


def rejected_moves(problem: RouteProblem, placed: PlacedRoute) -> list[tuple[int, Rejection]]:
    """Follow every move of a route; give the first step of each inadmissible one, and why it is."""
    first = np.arange(len(placed.region) - 1)
    ends = np.stack([first, first + 1], axis=1)
    checks = check_moves(problem.config, problem.machine, placed.pose[ends], placed.q_m[ends])
    return [(step, rejection) for step, rejection in enumerate(checks.rejections) if rejection is not None]
