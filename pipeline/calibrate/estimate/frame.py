"""The rigid motion between two sets of points, by Kabsch's method (Acta Cryst. A 32, 1976)."""

from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray

_TRIMMED = 4.0
"""Points farther off than so many medians have no part in a robust fit."""
_ROUNDS = 8


class Frame(NamedTuple):
    """seen = rotation points + translation_m, and by how much every point is off (n,)."""

    rotation: FloatArray
    translation_m: FloatArray
    miss_m: FloatArray

    @property
    def median_m(self) -> float:
        """Median of what points are off: what most are off, whatever a few are."""
        return float(np.median(self.miss_m))


def fit_frame(points_m: FloatArray, seen_m: FloatArray, mirrored: bool = False) -> Frame:
    """Fit the frame in which points (n, 3) are seen where they are (n, 3), by least squares.

    `mirrored` asks for the best improper rotation: that of a left-handed frame.
    """
    centre, middle = points_m.mean(axis=0), seen_m.mean(axis=0)
    U, _, Vt = np.linalg.svd((seen_m - middle).T @ (points_m - centre))
    handed = np.sign(np.linalg.det(U) * np.linalg.det(Vt)) * (-1.0 if mirrored else 1.0)
    rotation = U @ np.diag([1.0, 1.0, handed]) @ Vt
    translation = middle - rotation @ centre
    return Frame(rotation, translation, np.linalg.norm(points_m @ rotation.T + translation - seen_m, axis=1))


def fit_frame_robustly(points_m: FloatArray, seen_m: FloatArray, mirrored: bool = False) -> Frame:
    """Fit a frame to the points that agree on one: the nearer half again and again, then all within a few medians."""
    miss = fit_frame(points_m, seen_m, mirrored).miss_m
    for part in (*[1.0] * _ROUNDS, _TRIMMED):
        near = miss <= part * np.median(miss)
        rotation, translation, _ = fit_frame(points_m[near], seen_m[near], mirrored)
        miss = np.linalg.norm(points_m @ rotation.T + translation - seen_m, axis=1)
    return Frame(rotation, translation, miss)
