"""Tests of what is certain of boxes: poses drawn from them never contradict it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.bound.chart import chart_point
from pipeline.bound.evaluate import Evaluator
from pipeline.machine.geometry import Machine
from tests.fuzzing import FACTOR

Place = Callable[[Machine, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


def _random_boxes(
    machine: Machine, place: Place, rng: np.random.Generator, count: int
) -> tuple[FloatArray, FloatArray]:
    """Draw boxes (6, n) of many sizes and shapes around poses within reach."""
    angles = rng.uniform([-0.3, -0.6, -0.52, -0.52], [3.4, 0.9, 0.52, 0.52], (count, 4)).T
    D = place(machine, angles)[2]
    reached = (D > 0.0).all(axis=0)
    s = np.sqrt(D[:, reached]) * rng.choice([-1.0, 1.0], (2, int(reached.sum())))
    points = np.vstack([angles[:, reached], s])
    half = 10.0 ** (rng.uniform(-3.0, -0.7, points.shape[1]) + rng.uniform(-0.3, 0.3, points.shape))
    middle = points + rng.uniform(-1.0, 1.0, points.shape) * half
    return middle - half, middle + half


@pytest.mark.fuzz
@pytest.mark.parametrize("target", [24.0, 28.0, 40.0, 100.0, 1000.0])
def test_no_pose_contradicts_a_box(
    evaluator: Evaluator, reference: tuple[Machine, Any], place: Place, judge: Callable[..., Any], target: float
):
    """Poses of the start's sign within the limits have a larger kappa than K in every box that is excluded."""
    machine, rng, tested = reference[0], np.random.default_rng(int(target)), 0
    evaluate = Evaluator(evaluator.chart, evaluator.sign, target)
    for _ in range(FACTOR):
        low, high = _random_boxes(machine, place, rng, 400)
        excluded = evaluate(low, high).excluded
        box = np.repeat(np.flatnonzero(excluded), 60)
        angles = rng.uniform(low[:4, box], high[:4, box])
        pose, joints, D = place(machine, angles)
        for signs in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
            s = np.sqrt(np.maximum(D, 0.0)) * np.array(signs)[:, None]
            held = ((D >= 0.0) & (s >= low[4:, box]) & (s <= high[4:, box])).all(axis=0)
            carts = np.column_stack([joints[:, 0, 0] - s[0], joints[:, 1, 0] - s[1], np.zeros(len(box))])
            found = judge(machine, pose[held], carts[held])
            assert not (found.inside & (found.sign == evaluator.sign) & (found.kappa <= target)).any()
            tested += int(held.sum())
    assert tested > 300 * FACTOR


def test_bounds_are_sharp(evaluator: Evaluator, reference: tuple[Machine, Any]):
    """A box of a hundredth about the start loses 4 % of its kappa, one of a thousandth half a percent."""
    end = reference[1][0]
    point = chart_point(evaluator.chart, end)[:, None]
    for half, share in ((1e-3, 0.995), (1e-2, 0.96)):
        for factor, excluded in ((share, True), (1.0 + 1e-9, False)):
            found = Evaluator(evaluator.chart, evaluator.sign, factor * end.kappa)(point - half, point + half)
            assert bool(found.excluded[0]) is excluded
            assert found.middle[0] == pytest.approx(end.kappa, rel=1e-3)


def test_the_other_sign_is_excluded_as_a_whole(evaluator: Evaluator, reference: tuple[Machine, Any]):
    """With the other sign of det H wanted, boxes about the start hold no pose at all."""
    point = chart_point(evaluator.chart, reference[1][0])[:, None]
    other = Evaluator(evaluator.chart, -evaluator.sign, 1e6)
    assert other(point - 0.02, point + 0.02).excluded[0]


@pytest.mark.parametrize(
    ("shift", "why"),
    [
        ([0, 0, 0, 0, 0.3, 0], "reach"),
        ([0, 0, 0, 0, -2.0, 0], "reach"),
        ([3.0, 0, 0, 0, 0, 0], "reach of arms 1 and 2"),
    ],
)
def test_boxes_without_poses_are_excluded(
    evaluator: Evaluator, reference: tuple[Machine, Any], shift: list[float], why: str
):
    """Where s_k^2 = D_k has no solution there is no pose."""
    point = chart_point(evaluator.chart, reference[1][0])[:, None] + np.array(shift)[:, None]
    assert evaluator(point - 0.01, point + 0.01).excluded[0], why
