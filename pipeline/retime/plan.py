"""TOPP-RA on the spline itself: the fastest time law within the limits at the points of a grid.

The planner sees s in [0, 1], time in units of a rough guess of the duration and actuators in units of their
acceleration limit: its tolerances are absolute, and this keeps all that it compares near one, whatever the machine.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType, JointAccelerationConstraint, JointVelocityConstraint
from toppra.interpolator import AbstractGeometricPath

from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import FloatArray
from pipeline.refine.result import Path
from pipeline.retime.result import Trajectory

_GUESS_POINTS = 1_000
_ADVICE = "Raise retime.grid_points, or ask for a smoother path (fewer refine.coefficients)."


class _ScaledPath(AbstractGeometricPath):  # type: ignore[misc]  # toppra has no types
    """The path as the planner wants to see it, every actuator divided by a scale (5,)."""

    def __init__(self, path: Path, scale: FloatArray) -> None:
        self._path = path
        self._scale = scale

    def __call__(self, path_positions: FloatArray, order: int = 0) -> FloatArray:
        return self._path.q(path_positions, order) / self._scale

    @property
    def dof(self) -> int:
        return len(self._scale)

    @property
    def path_interval(self) -> FloatArray:
        return np.array([0.0, 1.0])


def plan(path: Path, grid_points: int) -> Trajectory:
    """Find the fastest way along the path, from rest to rest (TOPP-RA; Pham and Pham, 2018).

    Velocities hold at the grid points, accelerations at both ends of every interval ("interpolation" scheme); the
    path acceleration is constant in between, so that the law is a piecewise quadratic s(t).

    Raises
    ------
    NoSolutionError
        When the planner fails; says where.
    """
    s = grid(grid_points)
    unit_s = _rough_duration(path)
    sd = _path_velocities(path, s, unit_s) / unit_s
    ds = np.diff(s)
    return Trajectory.from_breakpoints(
        path,
        t_s=np.concatenate([[0.0], np.cumsum(2.0 * ds / (sd[1:] + sd[:-1]))]),
        s=s,
        sd=sd,
        sdd=np.append(np.diff(sd**2) / (2.0 * ds), 0.0),
    )


def grid(points: int) -> FloatArray:
    """Points of s in [0, 1], dense at both ends (cosine spacing): there s moves slowly, and even cells take long."""
    s: FloatArray = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, points)))
    return s


def _rough_duration(path: Path) -> float:
    """Guess the duration in seconds: at the velocity limits throughout, plus for getting that far at all."""
    rates = np.abs(path.q(np.linspace(0.0, 1.0, _GUESS_POINTS), 1))
    cruising = (rates / path.machine.velocity_mps).max(axis=1).mean()
    starting = np.sqrt((rates.mean(axis=0) / path.machine.acceleration_mps2).max())
    return float(cruising + starting)


def _path_velocities(path: Path, s: FloatArray, unit_s: float) -> FloatArray:
    """Path velocities ds/dt at the grid points, per `unit_s`. Shape (n,)."""
    machine = path.machine
    scale = machine.acceleration_mps2 * unit_s**2
    velocity = machine.velocity_mps * unit_s / scale
    with _solver_messages() as messages:
        planner = TOPPRA(
            [
                JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
                JointAccelerationConstraint(
                    np.stack([-np.ones_like(scale), np.ones_like(scale)], axis=1),
                    discretization_scheme=DiscretizationType.Interpolation,
                ),
            ],
            _ScaledPath(path, scale),
            gridpoints=s,
            solver_wrapper="seidel",
        )
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
        raise _failure("found no way on that keeps within the acceleration limits", s[np.argmax(stuck)], messages)
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
