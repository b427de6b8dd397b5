"""Tests of floods: what walks from the start cannot leave."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.bound.bound import build_evaluator
from pipeline.bound.chart import chart_point
from pipeline.bound.flood import Verdict, flood
from pipeline.config import Config
from pipeline.machine.geometry import build_machine
from pipeline.route.regions.endpoints import task_endpoints

KAPPA = 40.0


@pytest.mark.fuzz
def test_walks_stay_in_the_component(quick_config: Config, vary: Callable[..., Config], place: Any, judge: Any):
    """Random walks without tilt, kappa <= K, through changes of working mode stay in boxes reached from the start."""
    config = vary(quick_config, {"task.locked_axes": ["rx", "rz"]})
    machine = build_machine(config.machine)
    ends = task_endpoints(config, machine)
    evaluator = build_evaluator(config, machine, ends, KAPPA)
    start, goal = (chart_point(evaluator.chart, end) for end in ends)
    found = flood(evaluator, start, goal, 20_000)
    assert found.verdict is Verdict.NONE
    rng = np.random.default_rng(4)
    at, seen = np.repeat(start[:, None], 50, axis=1), []
    for _ in range(150):
        angles = at[:4] + [[1.0], [1.0], [0.0], [0.0]] * rng.normal(size=(4, 50)) * 10.0 ** rng.uniform(-2.5, -0.7, 50)
        pose, joints, D = place(machine, angles)
        # An arm may change its working mode where D is small, as it does between two steps.
        change = (rng.random(D.shape) < 0.3) & (D < 0.02)
        s = np.sqrt(np.maximum(D, 0.0)) * np.where(change, -1.0, 1.0) * np.sign(at[4:])
        carts = np.column_stack([joints[:, 0, 0] - s[0], joints[:, 1, 0] - s[1], np.zeros(50)])
        there = judge(machine, pose, carts)
        good = (D > 0.0).all(axis=0) & there.inside & (there.sign == evaluator.sign) & (there.kappa <= KAPPA)
        at = np.where(good, np.vstack([angles, s]), at)
        seen.append(at)
    points = np.concatenate(seen, axis=1)
    assert np.ptp(points[0]) > 0.3
    assert _held(found, points).all()


def _held(found: Any, points: FloatArray) -> FloatArray:
    """Tell which points (6, n) are in a box of the component."""
    chart, boxes = found.boxes.chart, found.boxes
    scale = (chart.high - chart.low)[:, None] / 2**24
    low, high = (chart.low[:, None] + scale * part[:, found.component] for part in (boxes.low, boxes.high))
    inside = np.ones((points.shape[1], low.shape[1]), dtype=bool)
    for k in chart.free:
        inside &= (points[k, :, None] >= low[k] - 1e-9) & (points[k, :, None] <= high[k] + 1e-9)
    return np.asarray(inside.any(axis=1))
