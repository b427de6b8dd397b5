"""The paper's program, literally: (3)-(38) with the state vector of Fig. 4 and a big-M row for every implication.

It serves for reading alongside the paper, for solving on small grids, and for handing to other solvers as an MPS
file; the program that is solved at full size is in `core_program`. Three places differ from the printed equations:

- (23) as printed, -m delta + P <= X(j) - m, leaves P <= X(j) - m where delta = 0, which cuts off feasible points.
  The valid row is P - X(j) <= (M - X(j)) (1 - delta), and likewise X(j) - P <= (X(j) - m) (1 - delta) for (24).
- x is not a grid axis: instead of (18), P_x lies in the region's window where delta = 1.
- (25) multiplies two unknowns. With kappa of the goal taken as zero, kappa_i = kappa(j) is equivalent.

Budgets of the task, which the paper does not have, are further columns and rows at the end: see `budget_rows`.
Moves that the paper does not mention (opposite signs of det H, links passing through each other, moves forbidden
after following them) are excluded by one more row per step and region: see `exclusions`.
"""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.route.bounds.budgets import Budget
from pipeline.route.cost.kappa_sum import region_costs
from pipeline.route.moves.candidates import Moves
from pipeline.route.programs.budget_rows import add_budgets, change_columns, change_entries
from pipeline.route.programs.exclusions import add_exclusions
from pipeline.route.programs.rows import Rows, Term
from pipeline.route.programs.size import ProgramSize
from pipeline.route.regions.table import RegionTable
from pipeline.solvers.highs import LinearProgram

HEAD = 13
"""Variables of a step before its region booleans: kappa, gamma, P_x, P_y, P_z, R_x, R_z, a_1..3, c_1..3."""
KAPPA, GAMMA, POSITION, MODE, CHANGE = 0, 1, 2, 7, 10


def paper_size(
    regions: int, step_budget: int, exclusions: int = 0, excluding: int = 0, budgets: tuple[Budget, ...] = ()
) -> ProgramSize:
    """Count columns, rows, booleans and matrix entries for N_d regions and N steps.

    `exclusions` are excluded ordered pairs, `excluding` the regions that have any.
    """
    N, Nd = step_budget, regions
    per_region = 2 * 5 + 2 + 2 * 6
    per_step = 1 + per_region * Nd + 4
    between = 2 * 5 + 2 * 3 + excluding
    entries_step = Nd + 2 * per_region * Nd + 8
    entries_between = 2 * 2 * 5 + 2 * 3 * 3 + excluding + exclusions
    changes = change_columns(budgets, N)
    return ProgramSize(
        columns=(HEAD + Nd) * N + changes,
        rows=per_step * N + between * (N - 1) + 2 * changes + len(budgets),
        booleans=(1 + 6 + Nd) * N,
        entries=entries_step * N + entries_between * (N - 1) + change_entries(budgets, N, (1,) * 8),
    )


def build_paper(
    regions: RegionTable,
    exclusions: Moves,
    steps: FloatArray,
    step_budget: int,
    budgets: tuple[Budget, ...] = (),
) -> LinearProgram:
    """Write (3)-(38) for a region table; `steps` (5,) are Delta X, Delta Y, Delta Z, Delta R_x, Delta R_z."""
    Nd, width = len(regions), HEAD + len(regions)
    extra = change_columns(budgets, step_budget)
    kappa = region_costs(regions)
    rows = Rows(columns=width * step_budget + extra)
    for i in range(step_budget):
        step = width * i
        delta = step + HEAD + np.arange(Nd)
        rows.add("(12) one region per step", [(delta, np.ones(Nd))], 1.0, 1.0)
        _positions(rows, regions, step, delta)
        _condition(rows, kappa, step, delta)
        _stopping(rows, step, delta[regions.goal])
        _modes(rows, regions, step, delta)
        if i > 0:
            _between(rows, regions, exclusions, steps, step - width, step)
    add_budgets(rows, budgets, _coordinate(width), step_budget, width * step_budget)
    cost = np.zeros(width * step_budget + extra)
    cost[width * np.arange(step_budget) + KAPPA] = 1.0  # (5)-(7)
    lower, upper, integer = _columns(regions, kappa, step_budget)
    lower, upper = np.append(lower, np.zeros(extra)), np.append(upper, np.full(extra, np.inf))
    matrix, row_bounds = rows.matrix()
    return LinearProgram(matrix, cost, (lower, upper), row_bounds, np.append(integer, np.zeros(extra, bool)))


def _coordinate(width: int) -> Callable[[int, int], Term]:
    """P_x to R_z and a_1 to a_3 are columns of their own."""

    def value(step: int, coordinate: int) -> Term:
        return np.array([width * step + POSITION + coordinate]), np.ones(1)

    return value


def _positions(rows: Rows, regions: RegionTable, step: int, delta: IntArray) -> None:
    """(18)-(24): P = X(j) where delta_ij = 1, by two big-M rows per region and coordinate; a window for x."""
    low = np.column_stack([regions.x_window_m[:, 0], regions.controlled[:, 1:]])
    high = np.column_stack([regions.x_window_m[:, 1], regions.controlled[:, 1:]])
    for axis in range(5):
        least, largest = low[:, axis].min(), high[:, axis].max()
        P = np.full(len(delta), step + POSITION + axis)
        one = np.ones(len(delta))
        rows.add_each("(23)", [(P, one), (delta, largest - high[:, axis])], -np.inf, largest)
        rows.add_each("(24)", [(P, -one), (delta, low[:, axis] - least)], -np.inf, -least)


def _condition(rows: Rows, kappa: FloatArray, step: int, delta: IntArray) -> None:
    """(25): kappa_i = kappa(j) where delta_ij = 1, the goal's being zero."""
    column = np.full(len(delta), step + KAPPA)
    one = np.ones(len(delta))
    rows.add_each("(25)", [(column, one), (delta, kappa.max() - kappa)], -np.inf, kappa.max())
    rows.add_each("(25)", [(column, -one), (delta, kappa)], -np.inf, 0.0)


def _stopping(rows: Rows, step: int, goal: int) -> None:
    """(26) by (27)-(30): gamma_i = 0 at the goal, 1 elsewhere."""
    columns = np.array([goal, step + GAMMA])
    for name, coefficients, limit in (
        ("(27)", (0.99, 1.0), 1.0),
        ("(28)", (-1.01, -1.0), -1.0),
        ("(29)", (1.01, 1.0), 1.01),
        ("(30)", (-0.99, -1.0), -0.99),
    ):
        rows.add(name, [(columns, np.array(coefficients))], -np.inf, limit)


def _modes(rows: Rows, regions: RegionTable, step: int, delta: IntArray) -> None:
    """(36)-(37): a_ik = A_k(j) and c_ik = C_k(j) where delta_ij = 1."""
    right = MODE_SIGNS[regions.modes] > 0.0
    gate = regions.gates[:, None] == np.arange(1, 4)
    one = np.ones(len(delta))
    for name, first, values in (("(36)", MODE, right), ("(37)", CHANGE, gate)):
        for k in range(3):
            column, value = np.full(len(delta), step + first + k), values[:, k].astype(float)
            rows.add_each(name, [(column, one), (delta, 1.0 - value)], -np.inf, 1.0)
            rows.add_each(name, [(column, -one), (delta, value)], -np.inf, 0.0)


def _between(rows: Rows, regions: RegionTable, exclusions: Moves, steps: FloatArray, before: int, step: int) -> None:
    """(13)-(17): largest moves; (38): modes change at gates only; and the excluded pairs."""
    for axis in range(5):
        columns = np.array([step + POSITION + axis, before + POSITION + axis])
        rows.add(f"({13 + axis})", [(columns, np.array([1.0, -1.0]))], -np.inf, steps[axis])
        rows.add(f"({13 + axis})", [(columns, np.array([-1.0, 1.0]))], -np.inf, steps[axis])
    for k in range(3):
        columns = np.array([step + MODE + k, before + MODE + k, before + CHANGE + k])
        rows.add("(38)", [(columns, np.array([1.0, -1.0, -1.0]))], -np.inf, 0.0)
        rows.add("(38)", [(columns, np.array([-1.0, 1.0, -1.0]))], -np.inf, 0.0)
    add_exclusions(rows, exclusions, before + HEAD, step + HEAD)


def _columns(regions: RegionTable, kappa: FloatArray, step_budget: int) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Bounds and integrality; (8)-(11) fix the first step to the start and the last to the goal."""
    Nd = len(regions)
    low = np.column_stack([regions.x_window_m[:, 0], regions.controlled[:, 1:]]).min(axis=0)
    high = np.column_stack([regions.x_window_m[:, 1], regions.controlled[:, 1:]]).max(axis=0)
    lower = np.tile(np.concatenate([[0.0, 0.0], low, np.zeros(6 + Nd)]), (step_budget, 1))
    upper = np.tile(np.concatenate([[kappa.max(), 1.0], high, np.ones(6 + Nd)]), (step_budget, 1))
    for row, region in ((0, regions.start), (-1, regions.goal)):
        upper[row, HEAD:] = 0.0
        lower[row, HEAD + region] = upper[row, HEAD + region] = 1.0
    integer = np.tile(np.concatenate([[False, True], np.zeros(5, bool), np.ones(6 + Nd, bool)]), (step_budget, 1))
    return lower.ravel(), upper.ravel(), integer.ravel()


def read_paper(values: FloatArray, regions: RegionTable, step_budget: int) -> tuple[IntArray, FloatArray]:
    """Read the region and the x of every step (N,) from a solution."""
    width = HEAD + len(regions)
    table = values[: step_budget * width].reshape(step_budget, width)
    return np.argmax(table[:, HEAD:], axis=1), table[:, POSITION]
