"""TOPP-RA on the spline itself: the fastest time law within the limits at the points of a grid, jerk left aside.

The planner sees s in [0, 1] and time in units of its own; limits are rows of fractions, computed
once for the whole grid. Its tolerances are absolute, and this keeps all it compares near one, whatever the machine.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType, LinearConstraint
from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate
from toppra.interpolator import AbstractGeometricPath

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime.constraints import Rows, limit_rows
from pipeline.retime.path_dynamics import TermsTable, grid, path_terms
from pipeline.retime.quantities import limits
from pipeline.retime.result import Trajectory
from pipeline.solvers.interrupts import interrupts_noted

_GUESS_POINTS = 1_000
_MOST_CRUISING = 2.0
"""Time at the velocity limits, relative to that for starting, up to which their sum is the unit of time."""
_LARGEST = 1e8
"""Stands for a path speed without a limit, in the planner's units."""
_ADVICE = "Raise retime.grid_points, or ask for a smoother path (fewer refine.coefficients)."


class _Unit(AbstractGeometricPath):  # type: ignore[misc]  # toppra has no types
    """The interval the planner works on; all that it has to know of the path is in the rows."""

    @property
    def dof(self) -> int:
        return 1

    @property
    def path_interval(self) -> FloatArray:
        return np.array([0.0, 1.0])


class _GivenRows(LinearConstraint):  # type: ignore[misc]  # toppra has no types
    """Second-order constraints a sdd + b sd^2 + c <= 1 and caps on sd^2, known at every point of the grid.

    They hold at both ends of every interval ("interpolation" scheme).
    """

    def __init__(self, rows: Rows) -> None:
        super().__init__()
        self.set_discretization_type(DiscretizationType.Interpolation)
        self.dof = 1
        self.identical = True
        self._rows = rows
        self._format_string = f"    {rows.a.shape[1]} rows"

    def compute_constraint_params(self, path: AbstractGeometricPath, gridpoints: FloatArray) -> tuple[object, ...]:
        rows, count = self._rows, self._rows.a.shape[1]
        cap = np.minimum(rows.cap**2, _LARGEST)
        a, b, c, F, g, _, _ = canlinear_colloc_to_interpolate(
            rows.a, rows.b, rows.c, np.eye(count), np.ones(count), None, None, gridpoints, identical=True
        )
        return a, b, c, F, g, None, np.stack([np.zeros_like(cap), cap], axis=1)


def plan(path: Path, grid_points: int, table: TermsTable | None = None) -> Trajectory:
    """Find the fastest way along the path, from rest to rest (TOPP-RA; Pham and Pham, 2018).

    Velocities hold at the grid points, accelerations and forces at both ends of every interval; the path acceleration
    is constant in between, so that the law is a piecewise quadratic s(t). Kinematics and dynamics are evaluated at the
    grid points, or taken from a table that is there already.

    Raises
    ------
    NoSolutionError
        When the planner fails; says where.
    """
    s = grid(grid_points)
    return plan_rows(path, s, limit_rows(path_terms(path, s) if table is None else table.at(s)))


def plan_rows(path: Path, s: FloatArray, rows: Rows) -> Trajectory:
    """Find the fastest way under limits that are known on a grid s (n,)."""
    unit_s = _unit_s(path)
    sd = _path_velocities(s, _in_units(rows, unit_s)) / unit_s
    ds = np.diff(s)
    return Trajectory.from_breakpoints(
        path,
        t_s=np.concatenate([[0.0], np.cumsum(2.0 * ds / (sd[1:] + sd[:-1]))]),
        s=s,
        sd=sd,
        sdd=np.append(np.diff(sd**2) / (2.0 * ds), 0.0),
    )


def _unit_s(path: Path) -> float:
    """Guess the duration in seconds: at the velocity limits throughout, plus for getting that far at all.

    Where starting takes next to no time of a slow motion, the unit is between the two: accelerations must not come
    near the planner's tolerances either.
    """
    rates = np.abs(path.q(np.linspace(0.0, 1.0, _GUESS_POINTS), 1))
    allowed = limits(path.machine)
    cruising = (rates / allowed["velocity"]).max(axis=1).mean()
    starting = np.sqrt((rates.mean(axis=0) / allowed["acceleration"]).max())
    return float(starting + min(cruising, np.sqrt(_MOST_CRUISING * cruising * starting)))


def _in_units(rows: Rows, unit_s: float) -> Rows:
    return Rows(rows.a / unit_s**2, rows.b / unit_s**2, rows.c, rows.cap * unit_s, rows.labels)


def _path_velocities(s: FloatArray, rows: Rows) -> FloatArray:
    """Path velocities at the grid points. Shape (n,)."""
    # Compiled code of toppra's would ignore Ctrl-C, and fail for it.
    with _solver_messages() as messages, interrupts_noted():
        planner = TOPPRA([_GivenRows(rows)], _Unit(), gridpoints=s, solver_wrapper="seidel")
        _, sd, _, controllable = planner.compute_parameterization(0.0, 0.0, return_data=True)
    if sd is None:
        # The controllable sets are computed from the goal backwards and end with the first that is not a number.
        lost = np.flatnonzero(np.isnan(controllable).any(axis=1))
        place = s[lost[0]] if lost.size else s[0]
        raise _failure("found no velocity from which the rest of the path can be driven", place, messages)
    velocities: FloatArray = np.asarray(sd, dtype=float)
    stuck = ~np.isfinite(velocities)
    stuck[1:-1] |= ~(velocities[1:-1] > 0.0)
    if stuck.any():
        raise _failure("found no way on that keeps within the limits", s[np.argmax(stuck)], messages)
    return velocities


def _failure(what: str, place: float, messages: list[str]) -> NoSolutionError:
    return NoSolutionError(
        "retime",
        f"the time-optimal planner {what}, at s = {place:.4f}",
        _ADVICE,
        {"s": float(place), "solver_messages": tuple(messages)},
    )


@contextmanager
def _solver_messages() -> Iterator[list[str]]:
    """Collect what toppra would log, so that a failure can tell it and nothing else is disturbed."""
    messages: list[str] = []
    logger = logging.getLogger("toppra")
    handler = _Collector(messages)
    level, propagate = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.WARNING)
    logger.propagate = False
    try:
        yield messages
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = propagate


class _Collector(logging.Handler):
    def __init__(self, messages: list[str]) -> None:
        super().__init__()
        self._messages = messages

    def emit(self, record: logging.LogRecord) -> None:
        self._messages.append(record.getMessage())
