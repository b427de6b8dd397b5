"""Tests of what is verified of boxes: poses drawn from them never contradict it."""

from typing import Any

import numpy as np
import pytest

from pipeline.bound.evaluate import Evaluator
from pipeline.bound.recheck.boxes import Claim, verified
from tests.fuzzing import FACTOR


@pytest.mark.fuzz
@pytest.mark.parametrize("target", [24.0, 60.0, 1000.0])
def test_no_pose_contradicts_a_box(draw: Any, target: float):
    """Poses of the start's sign within the limits have a larger kappa than K in every box that is verified."""
    rng, tested = np.random.default_rng(int(target)), 0
    for _ in range(FACTOR):
        low, high = draw.boxes(rng, 200)
        good = verified(Claim(draw.machine, draw.sign, target), low, high)
        count, wrong = draw.poses(rng, low[:, good], high[:, good], target)
        assert wrong == 0
        tested += count
    assert tested > 100 * FACTOR


def test_what_the_search_excludes_is_verified(evaluator: Evaluator, draw: Any):
    """Both codes agree: all boxes that the search excludes hold again, if need be in parts."""
    low, high = draw.boxes(np.random.default_rng(7), 600)
    excluded = evaluator(low, high).excluded
    assert excluded.sum() > 100
    assert verified(Claim(draw.machine, draw.sign, evaluator.target), low[:, excluded], high[:, excluded]).all()
