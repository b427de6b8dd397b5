"""Bounds of velocity, acceleration and jerk: never below what a motion does, and hardly above it."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.inclusion.closure import working_precision
from pipeline.retime import Trajectory, prove_motion, require_proven
from pipeline.retime.proof.exact_motion import exact_motion
from pipeline.retime.proof.kinematic_use import goals, kinematic_use
from pipeline.retime.proof.motion_proof import kinematic_limits
from tests.retime.proof.conftest import PEAKS, at_rest_at_both_ends, limited_to, with_bump


def test_the_peaks_of_a_known_motion_lie_between_what_is_attained_and_what_is_proven(straight: Trajectory) -> None:
    """Velocity 15 / 8 / T, acceleration 10 / sqrt(3) / T^2, jerk 60 / T^3; the telescopes stand still."""
    use = prove_motion(straight).use
    known = 1.0 / 1.001
    assert (use.attained[:, :3] <= known * (1.0 + 1e-12)).all()
    assert (use.proven[:, :3] >= known).all()
    assert (use.proven[:, :3] <= 1.0005 * known).all()
    assert (use.proven[:, 3:] <= 1e-5).all()


def test_no_sample_is_above_the_bounds_and_these_are_sharp(curved: Trajectory) -> None:
    """40,001 instants of a curve with 25 knots."""
    t = np.linspace(0.0, curved.duration_s, 40_001)
    limits = kinematic_limits(curved.path.machine)
    sampled = np.stack([np.abs(curved.q(t, order)).max(axis=0) for order in (1, 2, 3)]) / limits
    proven = prove_motion(curved).use.proven
    assert (sampled <= proven).all()
    assert (proven <= 1.001 * sampled).all()


def test_a_peak_of_a_tenth_of_a_millisecond_is_found(straight: Trajectory) -> None:
    """A bump of s by 1e-12 is nowhere to be seen but in the jerk, which is 384 h / w^3 at its ends."""
    width, height = 1e-4, 1e-12
    use = prove_motion(with_bump(straight, 1.2345, width, height)).use
    jerk = 384.0 * height / width**3
    assert use.attained[2, 0] * PEAKS[2] * 1.001 == pytest.approx(jerk, rel=0.01)
    assert use.t_s[2, 0] == pytest.approx(1.23455, abs=1e-4)
    assert use.proven[1, 0] < 1.0


def test_limits_on_either_side_of_the_truth_are_told_apart(straight: Trajectory) -> None:
    """One part in a hundred thousand is kept for other arithmetic; a limit that is exceeded is not proven."""
    for factor, kept in ((1.00005, True), (0.99999, False)):
        limits = np.tile(factor * PEAKS[:, None], 5)
        with working_precision(96):
            use = kinematic_use(exact_motion(straight), limits)
        assert (use.proven <= 1.0).all() == kept


def test_quantities_without_a_limit_use_none_of_it(straight: Trajectory) -> None:
    """Infinite limits take no effort."""
    proof = prove_motion(at_rest_at_both_ends(limited_to(straight.path, 1.0, 10.0, np.inf)))
    assert (proof.use.proven[2] < 1e-5).all()
    assert "jerk" not in proof.fractions


def test_what_is_no_number_is_not_proven(straight: Trajectory) -> None:
    """A limit that is none is not kept; compared with NaN nothing would be used of it."""
    limits = np.tile(1.1 * PEAKS[:, None], 5)
    limits[1, 2] = np.nan
    with working_precision(96):
        use = kinematic_use(exact_motion(straight), limits)
    assert np.isinf(use.proven[1, 2])
    assert (np.delete(use.proven, 7) <= 1.0).all()
    with pytest.raises(NoSolutionError, match="c3 is not proven to keep its acceleration limit"):
        require_proven(_limited(straight, limits[1]))


def _limited(motion: Trajectory, acceleration: np.ndarray) -> Trajectory:
    machine = replace(motion.path.machine, acceleration_mps2=acceleration)
    return replace(motion, path=replace(motion.path, machine=machine))


def test_a_bound_is_good_enough_only_a_little_above_what_is_attained() -> None:
    """It is one just below a limit, so that the limit is proven, and above one beyond it."""
    good = goals(np.array([0.0, 0.5, 0.9999, 1.0, 1.2]))
    np.testing.assert_allclose(good, [1e-6, 0.5002, 1.0, 1.0004, 1.20048])
