"""The result of stage two: a path, a curve of actuator positions over s in [0, 1] with the pose it implies."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from pipeline.arguments import require_array, require_number, require_one_length, require_whole
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.kinematics import forward_kinematics
from pipeline.status import Status

_STILL, _STILL_M = 1e-9, 1e-12
"""An actuator stands still where its |q'| is at most this fraction of the largest plus this many metres."""


_ROUNDING = 1e-9
"""How far outside [0, 1] an s may be that rounding has carried there."""
MOST_DEGREE = 15
"""Largest degree of a path, and order of a derivative: the effort of the proof grows with its cube."""


def directions_of(q1: FloatArray) -> FloatArray:
    """Return the signs of q'(s) (n, 5), zero for an actuator that stands still: rounding has no direction."""
    speed = np.abs(q1)
    moves = speed > _STILL * speed.max(axis=1, keepdims=True) + _STILL_M
    return np.asarray(np.sign(q1) * moves, dtype=float)


@dataclass(frozen=True, eq=False)
class Path:
    """Splines q(s) of the five actuators; the pose is the solution of the closure equations near known ones.

    Attributes
    ----------
    machine : Machine
        The machine that moves.
    spline : BSpline
        q(s) in metres, coefficients (n, 5), s in [0, 1]. Degree 1 for the coarse path.
    node_s, node_pose : (k,), (k, 6)
        Known poses along the path, from which forward kinematics starts; s increases.
    motion_s : float or None
        If s is time, the duration T of the motion q(t / T): path and time law were found together, the motion begins
        and ends at rest without acceleration, and keeps all limits of velocity, acceleration and jerk. None: s is
        no time, and the path is still to be timed.

    Raises
    ------
    ArgumentError
        If degree, knots, coefficients or known poses are not finite real numbers of these shapes, or the duration is
        not positive.
    """

    machine: Machine
    spline: BSpline
    node_s: FloatArray
    node_pose: FloatArray
    motion_s: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        require_path(self)

    def q(self, s: FloatArray | float, derivative: int = 0) -> FloatArray:
        """Evaluate actuator positions (metres), or their derivative by s, for s in [0, 1] (...). Shape (..., 5).

        Raises
        ------
        ArgumentError
            If an s is outside [0, 1], by more than rounding (1e-9), or the derivative is below zero.
        """
        s, order = _path_parameter(s), require_whole("derivative", derivative, 0, MOST_DEGREE)
        return np.asarray(self.spline(s, nu=order), dtype=float)

    def pose(self, s: FloatArray | float) -> FloatArray:
        """Evaluate poses (x, y, z, rx, ry, rz) by forward kinematics, for s in [0, 1] (...). Shape (..., 6).

        Raises
        ------
        ArgumentError
            If an s is outside [0, 1], by more than rounding (1e-9).
        ForwardKinematicsError
            If the closure equations have no solution near the path's known poses.
        """
        s = _path_parameter(s)
        shape, s = np.shape(s), np.ravel(s)
        guess = self._guess(s) if self.spline.k > 1 else self._linear_guess(s)
        return forward_kinematics(self.machine, self.q(s), guess).reshape(*shape, 6)

    @cached_property
    def _guess(self) -> CubicSpline:
        return CubicSpline(self.node_s, self.node_pose)

    def _linear_guess(self, s: FloatArray) -> FloatArray:
        columns = [np.interp(s, self.node_s, column) for column in self.node_pose.T]
        return np.stack(columns, axis=1)


def require_path(path: Path) -> None:
    """Require what `Path` says of its arrays.

    Raises
    ------
    ArgumentError
        If they are something else.
    """
    spline = path.spline
    degree = require_whole("the degree of the path", spline.k, 0, MOST_DEGREE)
    knots = require_array("the knots of the path", spline.t, ("n",))
    coefficients = require_array("the coefficients of the path", spline.c, ("n", len(ACTUATORS)))
    if len(coefficients) < len(knots) - degree - 1 or not (np.diff(knots) >= 0.0).all():
        raise ArgumentError(
            "the knots of the path: expected increasing ones, with a coefficient for each basis function"
        )
    node_s = require_array("node_s", path.node_s, ("k",))
    node_pose = require_array("node_pose", path.node_pose, ("k", 6))
    require_one_length(node_s=node_s, node_pose=node_pose)
    # Between nodes a cubic spline or, for degree one, a straight line is the guess, which may stand still at a corner.
    grows = np.diff(node_s) > 0.0 if degree > 1 else np.diff(node_s) >= 0.0
    if len(node_s) < 2 or not grows.all():
        raise ArgumentError("node_s: expected at least two numbers that increase")
    if path.motion_s is not None:
        require_number("motion_s", path.motion_s, above=0.0)


def _path_parameter(s: FloatArray | float) -> FloatArray:
    return require_array("s", s, ("...",), least=-_ROUNDING, largest=1.0 + _ROUNDING)


@dataclass(frozen=True, eq=False)
class Refinement:
    """The refined path, the coarse one that it came from, and how it was found.

    Attributes
    ----------
    path, coarse : Path
        The refined path; the route's steps joined by straight lines in actuator space.
    status : Status
        CONVERGED if all constraints hold at the nodes and between them.
    iterations : int
        Iterations of IPOPT and steps of the sequential programs, over all meshes and rounds.
    rounds : int
        Checks between the nodes; before each further one, nodes were added where the one before failed.
    meshes : int
        Meshes solved on, each finer than the one before, until a finer one changed nothing.
    mesh_change : float or None
        Relative change of what is minimised by the last finer mesh; None if there was none, or no path on it.
    nodes : int
        Collocation nodes of the last mesh.
    surrogate_integral : float
        The integral of the smooth surrogate of kappa; the reported integral is of the true kappa.
    """

    path: Path
    coarse: Path
    status: Status
    iterations: int
    rounds: int
    meshes: int
    mesh_change: float | None
    nodes: int
    surrogate_integral: float
