"""Enclosures of holding forces on boxes that are wider than any proof needs: every term of the bound has to count."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.certify.recheck.arithmetic.inclusion import Boxes, build_boxes
from pipeline.certify.recheck.claims.gravity.holding_force import holding_force_bounds
from pipeline.inclusion.gravity.forces import holding_force_ranges
from pipeline.inclusion.krawczyk import Box
from pipeline.machine import Machine
from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, link_vectors, platform_arms, rotation
from pipeline.machine.masses import lumped_platform
from pipeline.refine import Path
from tests.inclusion.wide_boxes import bounded_in_balls, wide_box

SHIFT = np.array([2e-3, 2e-3, 2e-3, 0.0, 0.0, 0.0])
TURN = np.array([0.0, 0.0, 0.0, 2e-3, 2e-3, 2e-3])


def _box(path: Path, width: float) -> Box:
    return wide_box(path, width, 1e-3)


def _forces(machine: Machine, pose: np.ndarray, q_m: np.ndarray) -> np.ndarray:
    """Solve f' H' = w', moments in metres, for poses that close no link exactly: rows of H' are divided by lengths."""
    assert machine.masses is not None
    vectors = link_vectors(machine, pose, q_m[:, :3])
    lengths = np.tile(machine.lengths_m, (len(pose), 1))
    lengths[:, TELESCOPES] = q_m[:, 3:]
    rows = np.concatenate([vectors, np.cross(platform_arms(machine, pose), vectors)], axis=2) / lengths[..., None]
    body = lumped_platform(machine.masses, machine.platform_points_m)
    F = np.broadcast_to(-body.mass_kg * machine.masses.gravity_mps2, (len(pose), 3))
    r = rotation(*pose.T[3:]) @ body.centre_m
    wrench = np.concatenate([F, np.cross(r, F)], axis=1)
    f = np.linalg.solve(np.swapaxes(rows, 1, 2), wrench[..., None])[..., 0]
    d = machine.rail_directions
    along = f * (rows[..., :3] * d[ARM_OF_LINK]).sum(axis=-1)
    carts = np.stack([along[:, arm == ARM_OF_LINK].sum(axis=1) for arm in range(3)], axis=1)
    carts = carts - carried_cart_masses(machine.masses) * (d @ machine.masses.gravity_mps2)
    return np.column_stack([carts, f[:, TELESCOPES], f])


def _sampled(path: Path, box: Box, deviation: np.ndarray) -> np.ndarray:
    """Take forces at corners of the box, and at its cubic, all along the interval."""
    random = np.random.default_rng(5)
    s = np.repeat(np.linspace(box.first, box.last, 41), 60)
    t = s - (box.first + box.last) / 2.0
    pose = np.polynomial.polynomial.polyval(t, box.pose).T + deviation * random.choice([-1.0, 0.0, 1.0], (len(s), 6))
    return _forces(path.machine, pose, path.q(s))


Bound = Callable[[Path, Box, np.ndarray], np.ndarray]


def in_balls(path: Path, box: Box, deviation: np.ndarray) -> np.ndarray:
    """Bound forces in ball arithmetic."""
    return bounded_in_balls(holding_force_ranges, path, box, deviation)


def in_floats(path: Path, box: Box, deviation: np.ndarray) -> np.ndarray:
    """Bound forces by the arithmetic of the independent check."""
    assert path.machine.masses is not None
    boxes: Boxes = build_boxes(path.machine, path, (box,))
    return holding_force_bounds(path.machine, path.machine.masses, boxes, deviation[:, None])


@pytest.mark.parametrize("bound", [in_balls, in_floats])
@pytest.mark.parametrize("width", [1e-3, 0.02])
@pytest.mark.parametrize("deviation", [np.zeros(6), SHIFT, TURN, SHIFT + TURN], ids=["none", "shift", "turn", "both"])
def test_no_pose_of_a_box_takes_more_than_its_bound(path: Path, bound: Bound, width: float, deviation: np.ndarray):
    """On the cubic, and on poses that are off it, as far as the box says."""
    box = _box(path, width)
    sampled = _sampled(path, box, deviation)
    least, largest = bound(path, box, deviation).T
    assert np.isfinite([least, largest]).all()
    assert (least <= sampled.min(axis=0)).all()
    assert (sampled.max(axis=0) <= largest).all()
    assert (np.maximum(-least, largest) <= 3.0 * np.abs(sampled).max()).all()


@pytest.mark.parametrize("bound", [in_balls, in_floats])
@pytest.mark.parametrize("deviation", [SHIFT, TURN], ids=["shift", "turn"])
def test_poses_off_the_cubic_count(path: Path, bound: Bound, deviation: np.ndarray):
    """A bound for the cubic alone is exceeded: what accounts for the deviation is not idle."""
    box = _box(path, 1e-3)
    sampled = _sampled(path, box, deviation)
    least, largest = bound(path, box, np.zeros(6)).T
    assert (least > sampled.min(axis=0)).any()
    assert (largest < sampled.max(axis=0)).any()


def test_both_arithmetics_agree(path: Path):
    """The statement is the same; only how it is computed differs."""
    box = _box(path, 5e-3)
    for deviation in (np.zeros(6), SHIFT + TURN):
        floats, balls = in_floats(path, box, deviation), in_balls(path, box, deviation)
        # Of the wider range: an end near zero is far less certain than its own size.
        assert np.abs(floats - balls).max(axis=1) == pytest.approx(0.0, abs=0.02 * np.abs(balls).max(axis=1).min())
