"""Label setting over a core: the route of least cost within budgets, exactly.

A label is dropped when it cannot reach the goal within the budgets and the cost allowed, or when another one in the
same region, after as many steps or fewer, costs and uses no more wherever its x goes. What is left at the goal is the
optimum. Budgets that are almost used up leave few labels, where the relaxation of a mixed-integer program says little
(Desrosiers et al., *Time constrained routing and scheduling*, 1995).
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.route.core.build import Core
from pipeline.route.core.labels import Labels, LabelSearch
from pipeline.route.deadline import Deadline
from pipeline.route.programs.solution import StepSequence
from pipeline.solvers.highs import Outcome
from pipeline.status import Status

SOLVER = "label setting"
WIDTH = 10
"""Labels kept per region and step by a search that looks for some good route first."""
_MOST_LABELS = 200_000
"""Labels after which a search gives up: comparing them with each other takes the square of their number."""


def solve_labels(
    core: Core, prices: FloatArray, deadline: Deadline, cost: float = np.inf, width: int | None = None
) -> StepSequence:
    """Find the route of least cost over a core that is not empty.

    Parameters
    ----------
    prices : (budgets,)
        Lagrange multipliers of the budgets: good ones drop more labels.
    cost : float
        Routes that cost more are not looked for.
    width : int, optional
        Labels kept per region and step. With it the search is fast, and proves nothing.

    Returns
    -------
    StepSequence
        Its status is OPTIMAL or INFEASIBLE with a proof, for routes of at most `cost`; TIME_LIMIT or, when there are
        too many labels or `width` left some out, NOT_CONVERGED without.
    """
    search = LabelSearch.of(core, prices, cost)
    layers = [search.root()]
    known: dict[int, Labels] = {}
    best, last, complete, count = np.inf, (0, 0), True, 0
    for step in range(core.step_budget - 1):
        if count > _MOST_LABELS or (width is None and deadline.passed):
            status = Status.TIME_LIMIT if deadline.passed else Status.NOT_CONVERGED
            return _sequence(search, layers, last, best, status)
        ahead, at_goal = search.extend(layers[-1], best)
        if at_goal and at_goal[0] < best:
            best, last = at_goal[0], (step, at_goal[1])
        kept, cut = search.undominated(ahead, known, width)
        complete, count = complete and not cut, count + len(kept)
        if len(kept) == 0:
            break
        layers.append(kept)
    proven = Status.OPTIMAL if np.isfinite(best) else Status.INFEASIBLE
    return _sequence(search, layers, last, best, proven if complete else Status.NOT_CONVERGED)


def _sequence(
    search: LabelSearch, layers: list[Labels], last: tuple[int, int], cost: float, status: Status
) -> StepSequence:
    """Follow the parents of the last label before the goal, and choose x backwards: it stays as long as it can."""
    core = search.core
    bound = cost if status is Status.OPTIMAL else min(max(float(search.cost_to_go[0]), core.bound), cost)
    columns = len(core.tail)
    if not np.isfinite(cost):
        none = Outcome(status, np.empty(0), np.inf, np.inf if status is Status.INFEASIBLE else bound, np.inf)
        return StepSequence(np.empty(0, dtype=np.int64), np.empty(0), none, columns, SOLVER)
    region, x = [int(core.region[-1])], [float(core.window_m[-1, 0])]
    label = last[1]
    for step in range(last[0], -1, -1):
        layer = layers[step]
        region.append(int(core.region[layer.node[label]]))
        x.append(float(np.clip(x[-1], layer.reach[0, label], layer.reach[1, label])))
        label = int(layer.parent[label])
    outcome = Outcome(status, np.array(x[::-1]), cost, bound, (cost - bound) / cost if cost > 0.0 else 0.0)
    return StepSequence(np.array(region[::-1]), np.array(x[::-1]), outcome, columns, SOLVER)
