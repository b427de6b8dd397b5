"""Running TOPP-RA: the fastest speed profile under rows of linear inequalities on a grid (Pham and Pham, 2018)."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType, LinearConstraint
from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate
from toppra.interpolator import AbstractGeometricPath

from pipeline.arrays import FloatArray
from pipeline.solvers.interrupts import interrupts_noted

_LARGEST = 1e8
"""Replaces a squared path speed without a limit."""


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """What TOPP-RA found on a grid of n points.

    Attributes
    ----------
    sd : (n,)
        Path speeds; NaN from where no way on was found, and everywhere if there is none from the start.
    controllable : (n, 2)
        Bounds on the path speed from which the goal can be reached; NaN where it cannot, or where that is unknown.
    messages : tuple of str
        What toppra would have logged.
    """

    sd: FloatArray
    controllable: FloatArray
    messages: tuple[str, ...] = field(default=())


class _Unit(AbstractGeometricPath):  # type: ignore[misc]  # toppra has no types
    """The interval [0, 1]: all that the planner needs to know of the path is in the rows."""

    @property
    def dof(self) -> int:
        return 1

    @property
    def path_interval(self) -> FloatArray:
        return np.array([0.0, 1.0])


class _GivenRows(LinearConstraint):  # type: ignore[misc]  # toppra has no types
    """Constraints a sdd + b sd^2 + c <= 1 and caps on sd^2, known at every point of the grid.

    They hold at both ends of every interval ("interpolation" scheme).
    """

    def __init__(self, rows: tuple[FloatArray, FloatArray, FloatArray], cap: FloatArray) -> None:
        super().__init__()
        self.set_discretization_type(DiscretizationType.Interpolation)
        self.dof = 1
        self.identical = True
        self._rows, self._cap = rows, cap
        self._format_string = f"    {rows[0].shape[1]} rows"

    def compute_constraint_params(self, path: AbstractGeometricPath, gridpoints: FloatArray) -> tuple[object, ...]:
        count = self._rows[0].shape[1]
        cap = np.minimum(self._cap**2, _LARGEST)
        a, b, c, F, g, _, _ = canlinear_colloc_to_interpolate(
            *self._rows, np.eye(count), np.ones(count), None, None, gridpoints, identical=True
        )
        return a, b, c, F, g, None, np.stack([np.zeros_like(cap), cap], axis=1)


def fastest_profile(s: FloatArray, rows: tuple[FloatArray, FloatArray, FloatArray], cap: FloatArray) -> SpeedProfile:
    """Find the fastest speed profile sd(s) from rest to rest.

    Its tolerances are absolute: rows, and speeds in the unit of time chosen, have to be near one.

    Parameters
    ----------
    s : (n,)
        Grid, ascending from 0 to 1.
    rows : three (n, m)
        Coefficients of a sdd + b sd^2 + c <= 1.
    cap : (n,)
        Largest sd; may be infinite.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    # Compiled code of toppra's would ignore Ctrl-C, and fail for it.
    with _messages() as messages, interrupts_noted():
        planner = TOPPRA([_GivenRows(rows, cap)], _Unit(), gridpoints=s, solver_wrapper="seidel")
        _, sd, _, controllable = planner.compute_parameterization(0.0, 0.0, return_data=True)
    speeds = np.full(len(s), np.nan) if sd is None else np.asarray(sd, dtype=float)
    return SpeedProfile(speeds, np.asarray(controllable, dtype=float), tuple(messages))


@contextmanager
def _messages() -> Iterator[list[str]]:
    """Collect what toppra would log, and leave its logger as it was."""
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
