"""The rigid motion between two sets of points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.calibrate.estimate.frame import fit_frame, fit_frame_robustly

POINTS = np.random.default_rng(1).normal(size=(30, 3))
TURN = Rotation.from_rotvec([0.3, -2.0, 0.7]).as_matrix()
SHIFT = np.array([3.0, -2.0, 0.5])


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_frame_comes_back(mirrored: bool):
    """Points that are turned, shifted and perhaps mirrored give that motion, and no other handedness fits."""
    turn = TURN @ np.diag([1.0, 1.0, -1.0 if mirrored else 1.0])
    seen = POINTS @ turn.T + SHIFT
    frame = fit_frame(POINTS, seen, mirrored)
    np.testing.assert_allclose(frame.rotation, turn, atol=1e-14)
    np.testing.assert_allclose(frame.translation_m, SHIFT, atol=1e-14)
    assert frame.median_m < 1e-14
    other = fit_frame(POINTS, seen, not mirrored)
    assert other.median_m > 0.1
    np.testing.assert_allclose(np.linalg.det(other.rotation), 1.0 if mirrored else -1.0)


def test_a_few_wrong_points_do_not_count():
    """A quarter of points anywhere leave the robust frame as it is, and are what it misses."""
    seen = POINTS @ TURN.T + SHIFT + np.random.default_rng(2).normal(0.0, 1e-6, POINTS.shape)
    seen[::4] += 0.5
    frame = fit_frame_robustly(POINTS, seen)
    np.testing.assert_allclose(frame.rotation, TURN, atol=5e-6)
    assert (frame.miss_m > 0.5).nonzero()[0].tolist() == list(range(0, 30, 4))
