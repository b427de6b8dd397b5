"""The compact program in CP-SAT, which knows integers alone.

kappa in millionths, x in micrometres (windows rounded outwards), the other coordinates in millionths of a step
with a slack of two. What comes out is judged, and its cost added up, in the numbers it was rounded from.
"""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import ortools
from ortools.sat.python import cp_model

from tests.benchmarks.isolated import peak_mb
from tests.benchmarks.peers.reading import REGIONS

SCALE = 1_000_000
_ROUNDING = 2
_STATUS = {cp_model.OPTIMAL: "optimal", cp_model.INFEASIBLE: "infeasible"}
_ARM_SHIFT = np.array([2, 1, 0])


def compact(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the compact program with a worker per core, CP-SAT's default."""
    begin = time.perf_counter()
    with np.load(folder / REGIONS) as arrays:
        program = _Program(dict(arrays))
    built = time.perf_counter()
    told: dict[str, Any] = {"build_s": built - begin, "solver": f"CP-SAT {ortools.__version__}"}
    yield told
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = limit_s
    status = solver.solve(program.model)
    told |= {"seconds": time.perf_counter() - built, "status": _STATUS.get(status, "time limit"), "peak_mb": peak_mb()}
    told["bound"] = solver.best_objective_bound / SCALE
    if status in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        told["rows"] = np.array([[solver.boolean_value(d) for d in step] for step in program.delta]).argmax(axis=1)
        told["x_m"] = np.array([solver.value(x) for x in program.x]) / SCALE
    yield told


class _Program:
    """The compact program: delta_ij and P_x of every step; numbers in brackets are the paper's."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.model = cp_model.CpModel()
        self.table = table
        self.low = np.floor(table["x_window_m"][:, 0] * SCALE).astype(int)
        self.high = np.ceil(table["x_window_m"][:, 1] * SCALE).astype(int)
        steps, count = int(table["step_budget"]), len(self.low)
        self.delta = [[self.model.new_bool_var("") for _ in range(count)] for _ in range(steps)]
        self.x = [self.model.new_int_var(self.low.min(), self.high.max(), "") for _ in range(steps)]
        for i in range(steps):
            self._one_region(i)
        for i in range(1, steps):
            self._move(i)
            self._modes(i)
            self._exclusions(i)
        self.model.add(self.delta[0][-2] == 1)  # (8)-(11): the last two regions are the start and the goal
        self.model.add(self.delta[-1][-1] == 1)
        kappa = np.rint(table["kappa"] * SCALE).astype(int)
        kappa[-1] = 0
        self.model.minimize(sum(_sum(step, kappa) for step in self.delta))  # (5), (25)-(26)

    def _one_region(self, i: int) -> None:
        self.model.add_exactly_one(self.delta[i])  # (12)
        self.model.add(self.x[i] >= _sum(self.delta[i], self.low))  # (18)
        self.model.add(self.x[i] <= _sum(self.delta[i], self.high))

    def _move(self, i: int) -> None:
        """(13)-(17)."""
        step = round(self.table["steps"][0] * SCALE)
        self.model.add_linear_constraint(self.x[i] - self.x[i - 1], -step, step)
        cells = np.rint(self.table["controlled"][:, 1:] / self.table["steps"][1:] * SCALE).astype(int)
        limit = SCALE + _ROUNDING
        for axis in cells.T:
            self.model.add_linear_constraint(_sum(self.delta[i], axis) - _sum(self.delta[i - 1], axis), -limit, limit)

    def _modes(self, i: int) -> None:
        """(38)."""
        right = (self.table["mode"][:, None] >> _ARM_SHIFT) & 1
        gate = self.table["gate"][:, None] == np.arange(1, 4)
        for k in range(3):
            ahead, behind = _sum(self.delta[i], right[:, k]), self.delta[i - 1]
            self.model.add(ahead <= _sum(behind, right[:, k] + gate[:, k]))
            self.model.add(ahead >= _sum(behind, right[:, k] - gate[:, k]))

    def _exclusions(self, i: int) -> None:
        sources, begin = np.unique(self.table["excluded_source"], return_index=True)
        groups = np.split(self.table["excluded_target"], begin[1:])
        for source, targets in zip(sources, groups, strict=True):
            ahead = [self.delta[i][target] for target in targets]
            self.model.add_at_most_one([self.delta[i - 1][source], *ahead])


def _sum(booleans: list[Any], weights: Any) -> Any:
    return cp_model.LinearExpr.weighted_sum(booleans, weights)
