"""The optimum over one core: by outer approximation, label setting or one mixed-integer program."""

from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.route.bounds.shortest_paths import Bounds
from pipeline.route.core.build import Core
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.core_program import build_core_program, read_core
from pipeline.route.programs.solution import StepSequence, solve_steps
from pipeline.route.programs.travel_program import Tangents
from pipeline.route.search.label_setting import WIDTH, solve_labels
from pipeline.route.search.outer_approximation import approximate
from pipeline.status import Status


def solve_core(
    problem: RouteProblem, core: Core, bounds: Bounds, tangents: Tangents, known: StepSequence | None = None
) -> StepSequence:
    """Find the optimum over a core that is not empty; `known` is a route found before.

    Where travel along X costs, it is found by outer approximation; else by label setting where there are budgets, or by
    HiGHS. Budgets that are almost used up make the relaxations of a mixed-integer program weak and its incumbents rare;
    labels are then few. Should they be too many after all, HiGHS decides.
    """
    if problem.cost.counts_x:
        return approximate(problem, core, tangents, known)
    deadline = problem.deadline
    prices, monitor, some = np.array(bounds.prices.prices), deadline.shown(problem.monitor), None
    if core.budgets:
        monitor.progress("label setting")
        some = solve_labels(core, prices, deadline, width=WIDTH)
        found = solve_labels(core, prices, deadline, min(some.outcome.objective, core.threshold))
        if found.outcome.status is Status.OPTIMAL:
            return found
        if found.outcome.status is Status.INFEASIBLE:
            # Nothing within the threshold; what costs more says how far to raise it.
            return replace(some, outcome=replace(some.outcome, status=Status.INFEASIBLE))
    found = solve_steps(build_core_program(core), partial(read_core, core=core), deadline.left_s, monitor)
    if found.outcome.status in (Status.OPTIMAL, Status.INFEASIBLE):
        return found
    some = solve_labels(core, prices, deadline, width=WIDTH) if some is None else some
    better = found if found.outcome.objective <= some.outcome.objective else some
    bound = max(found.outcome.bound, some.outcome.bound)
    return replace(better, outcome=replace(better.outcome, status=found.outcome.status, bound=bound))
