"""The mixed-integer program of the paper, (3)-(38), over the core.

The paper has a boolean delta_ij per step i and region j, and ties positions and modes to it by big-M rows.
Over the core every admitted pair (delta_ij, delta_i+1,k) is an arc, and one boolean per arc replaces them all:

- (8)-(11): one unit leaves the start at the first step and reaches the goal at the last,
- (12): it is in one region per step, since what enters a node leaves it; delta_ij is what leaves (i, j),
- (14)-(17), (19)-(22), (36)-(38): every arc is a move admitted by `moves`,
- (25)-(35): an arc costs kappa of the region it leaves, and nothing once the goal is reached,
- (18) with a window instead of one value, since x is not a grid axis: lo_j <= P_x,i <= hi_j where delta_ij = 1,
- (13): |P_x,i - P_x,i-1| <= Delta X,
- (5): the sum of kappa is minimised,
- budgets: the arcs use no more than each in total; where x counts, columns for |P_x,i - P_x,i-1| are added.
"""

import numpy as np
from scipy.sparse import block_array, csc_array

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.core.build import Core
from pipeline.solvers.highs import LinearProgram


def build_core_program(core: Core) -> LinearProgram:
    """Write the program over a core that is not empty: a boolean per arc, P_x per step, its changes if they count."""
    step_budget, x_step_m = core.step_budget, core.x_step_m
    nodes, arcs = len(core.step), len(core.tail)
    column = np.arange(arcs)
    leaves = csc_array((np.ones(arcs), (core.tail, column)), shape=(nodes, arcs))
    enters = csc_array((np.ones(arcs), (core.head, column)), shape=(nodes, arcs))
    supply = np.zeros(nodes)
    supply[0], supply[-1] = 1.0, -1.0
    at_step = csc_array((np.ones(nodes), (core.step, np.arange(nodes))), shape=(step_budget, nodes))
    # delta of the last step is what enters it; of all others what leaves.
    delta = leaves + csc_array(enters.multiply((core.step == step_budget - 1)[:, None]))
    low, high = (at_step.multiply(core.window_m[:, k]) @ delta for k in (0, 1))
    eye = csc_array(np.eye(step_budget))
    difference = csc_array(np.diff(np.eye(step_budget), axis=0))
    rows: list[_Rows] = [
        ([leaves - enters, None], supply, supply),
        ([-low, eye], np.zeros(step_budget), np.full(step_budget, np.inf)),
        ([-high, eye], np.full(step_budget, -np.inf), np.zeros(step_budget)),
        ([None, difference], np.full(step_budget - 1, -x_step_m), np.full(step_budget - 1, x_step_m)),
    ]
    rows, changes = _with_budgets(core, rows, difference)
    return LinearProgram(
        matrix=csc_array(block_array([blocks for blocks, _, _ in rows], format="csc")),
        cost=np.concatenate([core.cost, np.zeros(step_budget + changes)]),
        column_bounds=(
            np.concatenate([np.zeros(arcs), np.full(step_budget, core.window_m[:, 0].min()), np.zeros(changes)]),
            np.concatenate(
                [np.ones(arcs), np.full(step_budget, core.window_m[:, 1].max()), np.full(changes, x_step_m)]
            ),
        ),
        row_bounds=(
            np.concatenate([low for _, low, _ in rows]),
            np.concatenate([high for _, _, high in rows]),
        ),
        integer=np.arange(arcs + step_budget + changes) < arcs,
    )


_Rows = tuple[list[csc_array | None], FloatArray, FloatArray]
"""Blocks of the matrix side by side, and the bounds of their rows."""


def _with_budgets(core: Core, rows: list[_Rows], difference: csc_array) -> tuple[list[_Rows], int]:
    """Add a row per budget; also how many columns that took: one per change of P_x when a budget counts them."""
    changes = difference.shape[0] if any(budget.travels for budget in core.budgets) else 0
    if changes:
        eye, none, endless = csc_array(np.eye(changes)), np.zeros(changes), np.full(changes, np.inf)
        rows = [([*blocks, None], low, high) for blocks, low, high in rows]
        rows += [([None, sign * difference, eye], none, endless) for sign in (1.0, -1.0)]
    for budget, used in zip(core.budgets, core.used, strict=True):
        blocks: list[csc_array | None] = [csc_array(used[None]), csc_array((1, core.step_budget))]
        if changes:
            blocks.append(csc_array(np.full((1, changes), float(budget.travels))))
        rows.append((blocks, np.array([-np.inf]), np.array([budget.limit])))
    return rows, changes


def read_core(values: FloatArray, core: Core) -> tuple[IntArray, FloatArray]:
    """Read the region and the x of every step (N,) from a solution."""
    arcs = len(core.tail)
    used = np.flatnonzero(values[:arcs] > 0.5)
    used = used[np.argsort(core.step[core.tail[used]])]
    region = core.region[np.concatenate([core.tail[used], core.head[used[-1:]]])]
    return region, values[arcs : arcs + core.step_budget]
