"""A path corrected for another machine: exact where that is possible, and otherwise as near as its reach lets it be."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.correct import Correction, correct_path, pose_errors, reach_gaps
from pipeline.correct.correction import controlled_errors, poses_as_driven
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.result import Path

S = np.linspace(0.0, 1.0, 2_001)


Ends = Callable[[Path, Machine], tuple[FloatArray, FloatArray]]


def test_the_same_machine_needs_no_correction(planned: Path, machine: Machine, ends: Ends) -> None:
    """Where the machine is the one that was planned for, dq is zero."""
    found = correct_path(planned, machine, ends(planned, machine))
    assert np.abs(found.change_m(S)).max() < 1e-9


def test_offsets_along_a_cart_are_made_up_for_exactly(planned: Path, machine: Machine, ends: Ends) -> None:
    """Joints that are farther along a cart are made up for by that cart: dq is the same everywhere."""
    offsets = machine.cart_offsets_m.copy()
    offsets[1:3, 0] += 3e-4
    other = replace(machine, cart_offsets_m=offsets)
    found = correct_path(planned, other, ends(planned, other))
    assert found.change_m(S) == pytest.approx(np.tile([0.0, -3e-4, 0.0, 0.0, 0.0], (len(S), 1)), abs=1e-9)
    assert np.abs(controlled_errors(found.path.pose(S), planned.pose(S))).max() < 1e-9


def test_a_real_machine_comes_as_near_as_its_reach_lets_it(planned: Path, real: Machine, corrected: Correction) -> None:
    """What is left is hardly more at most than it has to be where modes change; both ends are exact."""
    poses, reached = planned.pose(S), corrected.path.pose(S)
    left = pose_errors(S, reached, poses)
    before = pose_errors(S, poses_as_driven(planned, real, lambda q_m: q_m, S), poses)
    gaps = reach_gaps(planned, real, S, reached)
    assert [gap.arm for gap in gaps] == [2, 1, 3]
    farthest = max(abs(gap.gap_m) for gap in gaps)
    assert before.rms_m > 1e-3
    assert left.rms_m < 0.3 * farthest < 0.1 * before.rms_m + 1e-4
    assert 0.5 * farthest < left.position_m.max() < 1.2 * farthest
    assert abs(left.largest_s - next(gap.s for gap in gaps if abs(gap.gap_m) == farthest)) < 0.02
    assert np.abs(left.error[[0, -1]]).max() < 1e-9


def test_no_small_change_of_the_correction_is_better(planned: Path, real: Machine, corrected: Correction) -> None:
    """What is minimised grows along random directions: derivatives are right, and the end is a minimum."""
    spline = corrected.path.spline
    goal, random = planned.pose(S), np.random.default_rng(0)
    weights = np.array([1.0, 1.0, 1.0, real.characteristic_length_m, real.characteristic_length_m])

    def value(coefficients: FloatArray) -> float:
        path = replace(corrected.path, spline=BSpline(spline.t, coefficients, spline.k))
        bent = path.q(S, 2) - planned.q(S, 2)
        errors = controlled_errors(path.pose(S), goal) * weights
        return float(np.mean(np.sum(errors**2, axis=1)) + 1e-11 * np.mean(np.sum(bent**2, axis=1)))

    least = value(spline.c)
    for _ in range(3):
        step = 2e-5 * random.normal(size=spline.c.shape)
        step[[0, -1]] = 0.0
        assert value(spline.c + step) > least
        assert value(spline.c - step) > least


def test_a_path_with_its_own_time_law_still_begins_and_ends_at_rest(planned: Path, real: Machine, ends: Ends) -> None:
    """Three coefficients are alike at both ends, as they were planned; the motion takes as long."""
    c = planned.spline.c.copy()
    c[1:3], c[-3:-1] = c[0], c[-1]
    resting = replace(planned, spline=BSpline(planned.spline.t, c, planned.spline.k), motion_s=6.0)
    found = correct_path(resting, real, ends(resting, real)).path
    assert found.motion_s == 6.0
    assert np.abs(found.q(np.array([0.0, 1.0]), 1)).max() < 1e-9
    assert np.abs(found.q(np.array([0.0, 1.0]), 2)).max() < 1e-6


def test_another_machine_is_refused(planned: Path, machine: Machine, ends: Ends) -> None:
    """Where the machine cannot be assembled, the place is named, and what to do."""
    lengths = machine.lengths_m.copy()
    lengths[0] -= 0.3
    other = replace(machine, lengths_m=lengths)
    with pytest.raises(NoSolutionError, match="cannot be assembled near the planned pose at s = 0") as refused:
        correct_path(planned, other, (planned.q(0.0), planned.q(1.0)))
    assert "--plan-again" in refused.value.advice
