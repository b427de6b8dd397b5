"""The coarse path as a controller would drive it: straight moves in actuator space with rounded corners.

A corner q_i between moves in directions m_0 and m_1 (unit vectors, over actuator length l) becomes a blend of half
width d that leaves the first move d before the corner and joins the second d after it:

    q'(u) = m_0 + (m_1 - m_0) (6 u^5 - 15 u^4 + 10 u^3),   u = (l - l_i + d) / (2 d) in [0, 1]

Its largest distance from the corner is 5/32 d |m_1 - m_0|, when it passes it. q is of degree six and has three
continuous derivatives, which motion with limited jerk needs.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from pipeline.arguments import require_number
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.machine.kinematics import forward_kinematics
from pipeline.refine.result import Path

TOLERANCE_M = 0.005
"""Default of the largest distance from a corner, in actuator space."""

_DEGREE = 6
_JOINED = 3
"""Multiplicity of knots: degree minus this many derivatives are continuous."""
_PASSED = 5.0 / 32.0
_MOST_OF_A_MOVE = 0.499
"""Fraction of a move that a blend at either end may take: a little less than half, so that blends do not meet."""


def blended(coarse: Path, tolerance_m: float = TOLERANCE_M) -> Path:
    """Round the corners of a path of degree one, each by no more than the tolerance.

    Parameters
    ----------
    coarse : Path
        Straight moves between corners.
    tolerance_m : float
        Largest distance of the new path from a corner, in metres of actuator space; less where moves are too short.

    Returns
    -------
    Path
        The same moves over actuator length, scaled to s in [0, 1].

    Raises
    ------
    ArgumentError
        If the path is not of degree one, two of its corners are one place, or the tolerance is not positive.
    """
    tolerance_m = require_number("tolerance_m", tolerance_m, above=0.0)
    if coarse.spline.k != 1:
        raise ArgumentError(f"coarse: expected a path of degree 1, not {coarse.spline.k}")
    corners_s, corners = coarse.spline.t[1:-1], coarse.spline.c
    moves = np.diff(corners, axis=0)
    lengths = np.linalg.norm(moves, axis=1)
    if not (lengths > 0.0).all():
        raise ArgumentError(f"coarse: its corners {int(np.argmin(lengths)) + 1} and the next are one place")
    at = np.append(0.0, np.cumsum(lengths))
    directions = moves / lengths[:, None]
    half = _half_widths(lengths, directions, tolerance_m)
    knots = _knots(at, half)
    places = np.array([knots[i + 1 : i + 1 + _DEGREE].mean() for i in range(len(knots) - _DEGREE - 1)])
    # The mean of equal numbers may be larger than they are.
    places = np.minimum(places, at[-1])
    positions = _positions(places, at, corners, directions, half)
    spline = make_interp_spline(places / at[-1], positions, k=_DEGREE, t=knots / at[-1])
    return _posed(coarse, spline, np.interp(coarse.node_s, corners_s, at / at[-1]))


def _half_widths(lengths: FloatArray, directions: FloatArray, tolerance_m: float) -> FloatArray:
    """Compute the half widths d (corners - 2,) of the blends at all inner corners."""
    turns = np.linalg.norm(np.diff(directions, axis=0), axis=1)
    room = _MOST_OF_A_MOVE * np.minimum(lengths[:-1], lengths[1:])
    with np.errstate(divide="ignore"):
        return np.asarray(np.minimum(tolerance_m / (_PASSED * turns), room))


def _knots(at: FloatArray, half: FloatArray) -> FloatArray:
    """Place clamped knots over actuator length, where blends begin and end."""
    inner = np.sort(np.concatenate([at[1:-1] - half, at[1:-1] + half]))
    clamped = [np.zeros(_DEGREE + 1), np.repeat(inner, _JOINED), np.full(_DEGREE + 1, at[-1])]
    return np.concatenate(clamped)


def _positions(
    places: FloatArray, at: FloatArray, corners: FloatArray, directions: FloatArray, half: FloatArray
) -> FloatArray:
    """Evaluate the blended path at actuator lengths (k,). Shape (k, 5).

    In a blend, q = q_i + m_0 (l - l_i) + (m_1 - m_0) 2 d (u^6 - 3 u^5 + 5/2 u^4).
    """
    move = np.clip(np.searchsorted(at, places, side="right") - 1, 0, len(directions) - 1)
    q = corners[move] + directions[move] * (places - at[move])[:, None]
    for corner, d in enumerate(half, start=1):
        inside = np.abs(places - at[corner]) < d
        u = (places[inside] - at[corner] + d)[:, None] / (2.0 * d)
        before, after = directions[corner - 1], directions[corner]
        along = corners[corner] + before * (places[inside] - at[corner])[:, None]
        q[inside] = along + (after - before) * 2.0 * d * (u**6 - 3.0 * u**5 + 2.5 * u**4)
    return q


def _posed(coarse: Path, spline: BSpline, node_s: FloatArray) -> Path:
    """Find the poses of the new path near those of the old one, whose nodes may stand still."""
    node_s, kept = np.unique(node_s, return_index=True)
    poses = forward_kinematics(coarse.machine, spline(node_s), coarse.node_pose[kept])
    return replace(coarse, spline=spline, node_s=node_s, node_pose=poses)
