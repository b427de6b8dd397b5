"""Where boxes are placed: cubics through poses found by Newton's method. The proof does not rely on them."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import ForwardKinematicsError
from pipeline.inclusion.growth import LEAST_RADIUS
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.pieces import middle
from pipeline.refine.result import Path

_TERMS = 4
_NODES = np.cos(np.pi * (np.arange(_TERMS) + 0.5) / _TERMS)
"""Chebyshev nodes."""
_THINNEST = np.full(6, LEAST_RADIUS)
_INTERPOLATE = np.linalg.inv(np.vander(_NODES, _TERMS, increasing=True))


def guess_box(path: Path, first: float, last: float) -> Box | None:
    """Fit a cubic through four poses within an interval of s; None if the closures have no solution there."""
    centre, half = middle(first, last)
    try:
        poses = path.pose(centre + half * _NODES)
    except ForwardKinematicsError:
        return None
    return Box(first, last, (_INTERPOLATE @ poses) / half ** np.arange(_TERMS)[:, None], _THINNEST)


def point_box(s: float, pose: FloatArray, radius: FloatArray = _THINNEST) -> Box:
    """Make a box at a single s about a pose (6,)."""
    return Box(s, s, np.vstack([pose, np.zeros((_TERMS - 1, 6))]), radius)
