"""The compact program: the paper's, with its big-M rows added up; the plain baseline.

As exactly one delta_ij of a step is 1, P_i = sum of X(j) delta_ij replaces all rows of (18)-(24), and sums likewise
replace (25) and (36)-(37). Only (13) needs P_x itself. There is one boolean per step and region and a handful of
rows per step, but the relaxation stays weak: fractions of many regions add up to any position.
"""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import FloatArray, IntArray
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


def compact_size(
    regions: int, step_budget: int, exclusions: int = 0, excluding: int = 0, budgets: tuple[Budget, ...] = ()
) -> ProgramSize:
    """Count columns, rows, booleans and matrix entries; the parameters are those of `paper_size`."""
    N, Nd = step_budget, regions
    changes = change_columns(budgets, N)
    entries_step = Nd + 2 * (1 + Nd)
    entries_between = 2 + 2 * 4 * Nd + 2 * 6 * Nd + excluding + exclusions
    return ProgramSize(
        columns=(1 + Nd) * N + changes,
        rows=3 * N + (5 + 6 + excluding) * (N - 1) + 2 * changes + len(budgets),
        booleans=Nd * N,
        entries=entries_step * N + entries_between * (N - 1) + change_entries(budgets, N, (1, *[Nd] * 7)),
    )


def build_compact(
    regions: RegionTable,
    exclusions: Moves,
    steps: FloatArray,
    step_budget: int,
    budgets: tuple[Budget, ...] = (),
) -> LinearProgram:
    """Write the compact program: per step P_x, then a boolean per region; columns for budgets last."""
    Nd, width = len(regions), 1 + len(regions)
    extra = change_columns(budgets, step_budget)
    rows = Rows(columns=width * step_budget + extra)
    for i in range(step_budget):
        step = width * i
        delta = step + 1 + np.arange(Nd)
        rows.add("(12) one region per step", [(delta, np.ones(Nd))], 1.0, 1.0)
        P = (np.array([step]), np.ones(1))
        rows.add("(18) window of x, least", [P, (delta, -regions.x_window_m[:, 0])], 0.0, np.inf)
        rows.add("(18) window of x, largest", [P, (delta, -regions.x_window_m[:, 1])], -np.inf, 0.0)
        if i > 0:
            _between(rows, regions, exclusions, steps, step - width, step)
    add_budgets(rows, budgets, _coordinate(regions, width), step_budget, width * step_budget)
    lower = np.tile(np.concatenate([[regions.x_window_m[:, 0].min()], np.zeros(Nd)]), (step_budget, 1))
    upper = np.tile(np.concatenate([[regions.x_window_m[:, 1].max()], np.ones(Nd)]), (step_budget, 1))
    for row, region in ((0, regions.start), (-1, regions.goal)):  # (8)-(11)
        upper[row, 1:] = 0.0
        lower[row, 1 + region] = upper[row, 1 + region] = 1.0
    cost = np.append(np.tile(np.concatenate([[0.0], region_costs(regions)]), step_budget), np.zeros(extra))
    integer = np.append(np.tile(np.concatenate([[False], np.ones(Nd, bool)]), step_budget), np.zeros(extra, bool))
    bounds = np.append(lower, np.zeros(extra)), np.append(upper, np.full(extra, np.inf))
    matrix, row_bounds = rows.matrix()
    return LinearProgram(matrix, cost, bounds, row_bounds, integer)


def _coordinate(regions: RegionTable, width: int) -> Callable[[int, int], Term]:
    """P_x is a column; y, z, rx, rz and working modes are sums over the regions."""
    right = (MODE_SIGNS[regions.modes] > 0.0).astype(float)
    values = np.column_stack([regions.controlled, right])

    def value(step: int, coordinate: int) -> Term:
        if coordinate == 0:
            return np.array([width * step]), np.ones(1)
        return width * step + 1 + np.arange(len(regions)), values[:, coordinate]

    return value


def _between(rows: Rows, regions: RegionTable, exclusions: Moves, steps: FloatArray, before: int, step: int) -> None:
    """(13)-(17) and (38) in sums over the regions of two neighbouring steps."""
    ahead, behind = step + 1 + np.arange(len(regions)), before + 1 + np.arange(len(regions))
    rows.add("(13)", [(np.array([step, before]), np.array([1.0, -1.0]))], -steps[0], steps[0])
    for axis in range(1, 5):
        values = regions.controlled[:, axis]
        rows.add(f"({13 + axis})", [(ahead, values), (behind, -values)], -steps[axis], steps[axis])
    right = (MODE_SIGNS[regions.modes] > 0.0).astype(float)
    gate = (regions.gates[:, None] == np.arange(1, 4)).astype(float)
    for k in range(3):
        rows.add("(38)", [(ahead, right[:, k]), (behind, -right[:, k] - gate[:, k])], -np.inf, 0.0)
        rows.add("(38)", [(ahead, -right[:, k]), (behind, right[:, k] - gate[:, k])], -np.inf, 0.0)
    add_exclusions(rows, exclusions, before + 1, step + 1)


def read_compact(values: FloatArray, regions: RegionTable, step_budget: int) -> tuple[IntArray, FloatArray]:
    """Read the region and the x of every step (N,) from a solution."""
    width = 1 + len(regions)
    table = values[: step_budget * width].reshape(step_budget, width)
    return np.argmax(table[:, 1:], axis=1), table[:, 0]
