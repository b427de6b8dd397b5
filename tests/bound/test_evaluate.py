"""Tests of what is certain of boxes: poses drawn from them never contradict it."""

from typing import Any

import numpy as np
import pytest

from pipeline.bound.chart import chart_point
from pipeline.bound.evaluate import Evaluator
from pipeline.machine.geometry import Machine
from tests.fuzzing import FACTOR


@pytest.mark.fuzz
@pytest.mark.parametrize("target", [24.0, 28.0, 40.0, 100.0, 1000.0])
def test_no_pose_contradicts_a_box(evaluator: Evaluator, draw: Any, target: float):
    """Poses of the start's sign within the limits have a larger kappa than K in every box that is excluded."""
    rng, tested = np.random.default_rng(int(target)), 0
    evaluate = Evaluator(evaluator.chart, evaluator.sign, target)
    for _ in range(FACTOR):
        low, high = draw.boxes(rng, 400)
        excluded = evaluate(low, high).excluded
        count, wrong = draw.poses(rng, low[:, excluded], high[:, excluded], target)
        assert wrong == 0
        tested += count
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
