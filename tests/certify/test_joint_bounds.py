"""Bounds of joint angles over a box, by both arithmetics: true of every pose in it, also where cosines bend."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes
from pipeline.certify.recheck.claims.joints.angles import joint_cosines
from pipeline.inclusion.bounds import joint_cosine
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.krawczyk import Box, Inclusion, along
from pipeline.inclusion.pieces import Piece, pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine import Machine
from pipeline.machine.geometry import link_lengths, link_vectors, rotation, turned
from pipeline.machine.joints.cone import JointCone
from pipeline.refine import Path
from tests.certify.audit import cubic
from tests.certify.paths import START, pose_path
from tests.joints import every_cone, with_cones

OFF = np.array([2e-3, 1e-3, 2e-3, 3e-3, 2e-3, 3e-3])
"""How far poses may be from the cubic, metres and radians: much more than a proof would leave."""


@dataclass(frozen=True, eq=False)
class Bent:
    """A path that goes away and comes back, within one box."""

    path: Path
    piece: Piece
    box: Box

    def bound(self, one: JointCone, off: np.ndarray) -> tuple[float, float]:
        """Bound a cosine by the arithmetic of the proof, and by that of the check."""
        machine = self.path.machine
        balls = geometry(machine)
        inclusion = Inclusion(self.box, np.zeros((2, 6, 6)), [arb(value) for value in off.tolist()], [arb(0)] * 6, [])
        with working_precision(64):
            proven = ProvenBox(machine, balls, self.piece, along(balls, self.piece, self.box), inclusion)
            found, *_ = joint_cosine(proven, one)
        single = with_cones(machine, one)
        ((again,),) = joint_cosines(single, build_boxes(single, self.path, (self.box,)), of_pose(single, off[:, None]))
        return found, float(again)

    def cosines(self, one: JointCone, off: np.ndarray) -> np.ndarray:
        """Compute cosines at many poses as far off the cubic as that, the first and the last at both ends of the box.

        They are (e . v) / len, also where v is not as long as the link.
        """
        random, machine = np.random.default_rng(2), self.path.machine
        s = np.linspace(self.box.first, self.box.last, 3_001)
        pose, q = cubic(self.box, s) + off * random.choice([-1.0, 1.0], (len(s), 6)), self.path.q(s)
        vector = link_vectors(machine, pose, q[:, :3])[:, one.link] / link_lengths(machine, q[:, 3:])[:, [one.link]]
        axis = turned(rotation(*pose[:, 3:].T), one.axis) if one.at_platform else one.axis
        return np.asarray((-1.0 if one.at_platform else 1.0) * (vector * axis).sum(axis=1))


@pytest.fixture(scope="module")
def bent(machine: Machine) -> Bent:
    """Go away by centimetres and ten degrees, and come back."""
    s = np.linspace(0.0, 1.0, 6)
    away = np.array([0.02, 0.06, -0.05, 0.17, -0.14])
    path = pose_path(machine, START + np.outer(4.0 * s * (1.0 - s), away), 0, 6)
    (piece,) = pieces(path.spline)
    box = guess_box(path, 0.3, 0.7)
    assert box is not None
    return Bent(path, piece, box)


@pytest.mark.parametrize("off", [0.0 * OFF, OFF])
def test_bounds_hold_at_every_pose_of_a_box(bent: Bent, off: np.ndarray) -> None:
    """At all joints; some bend downward in between, where the ends of the box say nothing."""
    low = 0
    for one in every_cone(90.0):
        least = bent.cosines(one, off)
        low += least.min() < min(bent.cosines(one, 0.0 * off)[[0, -1]]) - 0.01
        for bound in bent.bound(one, off):
            assert bound <= least.min()
            assert bound > least.min() - 0.1
    assert low >= 2


def test_poses_off_the_cubic_count(bent: Bent) -> None:
    """A bound for poses on the cubic alone is not one for those beside it."""
    wrong = [
        bound > bent.cosines(one, 10.0 * OFF).min() for one in every_cone(90.0) for bound in bent.bound(one, 0.0 * OFF)
    ]
    assert any(wrong)


def test_narrow_boxes_have_sharp_bounds(machine: Machine, bent: Bent) -> None:
    """The error falls with the square of the width."""
    errors = []
    for width in (0.1, 0.05, 0.025):
        box = guess_box(bent.path, 0.3, 0.3 + width)
        assert box is not None
        narrow = replace(bent, box=box)
        errors.append(
            [
                narrow.cosines(one, 0.0 * OFF).min() - bound
                for one in every_cone(90.0)
                for bound in narrow.bound(one, 0.0 * OFF)
            ]
        )
    wide, middle, small = (np.array(error) for error in errors)
    assert (small >= 0.0).all()
    assert (small < middle / 2.5 + 1e-12).all()
    assert (middle < wide / 2.5 + 1e-12).all()
