"""Enclosures of the stiffness by gravity, in both arithmetics."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.certify.recheck.arithmetic.inclusion import build_boxes
from pipeline.certify.recheck.claims.gravity.stiffness import stiffness_bounds
from pipeline.inclusion.gravity.stiffness import least_stiffness_bound
from pipeline.inclusion.krawczyk import Box
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from tests.inclusion.wide_boxes import bounded_in_balls, wide_box

FIRST = 0.3


def _box(path: Path, width: float) -> Box:
    return wide_box(path, width, 1e-4)


Bound = Callable[[Path, Box, np.ndarray], float]


def in_balls(path: Path, box: Box, deviation: np.ndarray) -> float:
    """Bound the stiffness in ball arithmetic."""
    return bounded_in_balls(least_stiffness_bound, path, box, deviation)[0]


def in_floats(path: Path, box: Box, deviation: np.ndarray) -> float:
    """Bound the stiffness by the arithmetic of the independent check."""
    assert path.machine.masses is not None
    boxes = build_boxes(path.machine, path, (box,))
    return float(stiffness_bounds(path.machine, path.machine.masses, boxes, deviation[:, None])[0])


def _sampled(path: Path, box: Box) -> float:
    """Take the least stiffness along a box."""
    s = np.linspace(box.first, box.last, 41)
    return float(PoseSamples(path.machine, path.pose(s), path.q(s)).gravity_stiffness_npm.min())


@pytest.mark.parametrize("bound", [in_balls, in_floats])
def test_bounds_are_below_all_samples_and_become_sharp(path: Path, bound: Bound) -> None:
    """With the width of the box what is given away falls with its square, down to nothing."""
    given_away = []
    for width in (0.02, 0.01, 0.005, 1e-4):
        box = _box(path, width)
        least = _sampled(path, box)
        given_away.append(least - bound(path, box, np.zeros(6)))
    assert min(given_away) >= 0.0
    assert given_away[-1] < 1e-3 * abs(least)
    assert given_away[1] < 0.3 * given_away[0]
    assert given_away[2] < 0.3 * given_away[1]


@pytest.mark.parametrize("bound", [in_balls, in_floats])
@pytest.mark.parametrize("axis", range(6))
def test_poses_off_the_cubic_count(path: Path, bound: Bound, axis: int) -> None:
    """A deviation in any coordinate widens the bound, by no less than the slope of the stiffness."""
    box, h = _box(path, 1e-4), 1e-5
    s = np.array([(box.first + box.last) / 2.0])
    off = h * np.eye(6)[axis]
    ends = [
        PoseSamples(path.machine, path.pose(s) + sign * off, path.q(s)).gravity_stiffness_npm[0] for sign in (-1, 1)
    ]
    exact = bound(path, box, np.zeros(6))
    widened = bound(path, box, off)
    assert exact - widened >= 0.49 * abs(ends[1] - ends[0])
    assert widened <= min(ends) + 1e-6 * abs(exact)


def test_both_arithmetics_agree(path: Path) -> None:
    """The statement is the same; only how it is computed differs."""
    for width, deviation in ((1e-3, np.zeros(6)), (5e-3, np.full(6, 1e-7))):
        box = _box(path, width)
        floats, balls = in_floats(path, box, deviation), in_balls(path, box, deviation)
        assert floats == pytest.approx(balls, rel=1e-3)


@pytest.mark.parametrize("bound", [in_balls, in_floats])
def test_nothing_is_known_where_the_machine_may_be_singular(path: Path, bound: Bound) -> None:
    """A box of a metre and a radian holds singular poses."""
    assert bound(path, _box(path, 1e-3), np.ones(6)) == -np.inf
