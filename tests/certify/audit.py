"""Proven bounds compared with the truth: poses by Newton's method at many random s, in every box and at its ends."""

import numpy as np

from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.pieces import middle
from pipeline.machine.kinematics import newton
from pipeline.refine import Path

ROUNDING = 1e-10


def samples_in(box: Box, count: int = 40) -> np.ndarray:
    """Give s in a box, its ends included."""
    random = np.random.default_rng(7)
    return np.sort(np.concatenate([[box.first, box.last], random.uniform(box.first, box.last, count)]))


def cubic(box: Box, s: np.ndarray) -> np.ndarray:
    """Evaluate the cubic of a box. Shape (n, 6)."""
    t = s - middle(box.first, box.last)[0]
    return np.vander(t, 4, increasing=True) @ box.pose


def deviations(path: Path, box: Box) -> np.ndarray:
    """How far the true poses are from the cubic, (6,), in the most of many samples."""
    s = samples_in(box)
    pose, miss = newton(path.machine, path.q(s), path.pose(s))
    assert (miss < ROUNDING).all()
    worst: np.ndarray = np.abs(pose - cubic(box, s)).max(axis=0)
    return worst
