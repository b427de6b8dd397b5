"""Known answers: what the chain closes over, and where it breaks."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import brentq

from pipeline.certify import Certificate, chain
from pipeline.certify.chain import close_chain
from pipeline.certify.problem import build_problem
from pipeline.certify.reasons import ACTUATORS_JUMP, JUMP, NO_INCLUSION, NO_POSE, SPLINES_INCOMPLETE
from pipeline.inclusion.closure import working_precision
from pipeline.machine import Machine, inverse_kinematics, link_distances
from pipeline.machine.geometry import MODES
from pipeline.machine.kinematics import newton
from pipeline.refine import Path
from pipeline.refine.motion import kappa_along
from tests.certify.paths import (
    NODES,
    RLL,
    START,
    TOWARDS_SINGULARITY,
    Jumping,
    actuator_path,
    other_solution,
    pose_path,
    torn,
    two_branches,
)

Prove = Callable[..., Certificate]

S = np.linspace(0.0, 1.0, NODES)


def test_a_regular_path_is_certified(machine: Machine, line: Path, prove: Prove) -> None:
    """Its boxes follow one another from zero to one, and its ends are where they should be."""
    certificate = prove(machine, line)
    boxes = certificate.chain.boxes
    assert certificate.verdict == "certified"
    assert (boxes[0].first, boxes[-1].last) == (0.0, 1.0)
    assert all(box.last == after.first for box, after in pairwise(boxes))
    assert len(certificate.chain.joints) == len(boxes) + 1
    assert certificate.bounds is not None
    assert certificate.bounds.goal_miss < 1e-9


def test_bounds_hold_at_samples_and_are_sharp(machine: Machine, line: Path, prove: Prove) -> None:
    """The bound of kappa is above every sample, and within the excess allowed for."""
    bounds = prove(machine, line).bounds
    s = np.linspace(0.0, 1.0, 1_001)
    kappa, pose, q = kappa_along(line, s).max(), line.pose(s), line.q(s)
    assert bounds is not None
    assert kappa <= bounds.kappa <= 1.0101 * kappa
    assert (link_distances(machine, pose, q[:, :3]).min(axis=0) >= bounds.distances_m).all()
    assert (q.min(axis=0) >= bounds.actuators_m[:, 0]).all()
    assert (q.max(axis=0) <= bounds.actuators_m[:, 1]).all()
    assert (np.rad2deg(np.abs(pose[:, [3, 5]])).max(axis=0) <= bounds.tilt_deg).all()


def test_a_path_through_a_singularity_is_refused_there(machine: Machine, prove: Prove, singular_at: float) -> None:
    """The place is reported, and everything before it is proven."""
    path = pose_path(machine, START + singular_at * 1.25 * S[:, None] * TOWARDS_SINGULARITY, RLL)
    certificate = prove(machine, path, (RLL, RLL), least_width=1e-4)
    assert certificate.failure is not None
    assert certificate.failure.s == pytest.approx(0.8, abs=0.02)
    reason = certificate.failure.reason
    assert reason in (NO_INCLUSION, NO_POSE, JUMP) or "kappa" in reason.text
    assert certificate.chain.boxes[-1].last <= certificate.failure.s


def test_a_path_that_touches_a_singularity_without_crossing_it_is_refused(
    machine: Machine, prove: Prove, singular_at: float
) -> None:
    """The sign of det H is the same before and after."""
    along = singular_at - 0.8 * (S - 0.5) ** 2
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL)
    certificate = prove(machine, path, (RLL, RLL), least_width=1e-4)
    assert certificate.failure is not None
    assert certificate.failure.s == pytest.approx(0.5, abs=0.02)


def test_a_path_that_grazes_a_singularity_is_certified(machine: Machine, prove: Prove, singular_at: float) -> None:
    """A millimetre of pose away is a micrometre of actuators; the bound of kappa says how near it was."""
    along = singular_at - 0.003 - 0.8 * (S - 0.5) ** 2
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL)
    certificate = prove(machine, path, (RLL, RLL))
    kappa = kappa_along(path, np.linspace(0.0, 1.0, 10_001)).max()
    assert certificate.verdict == "certified"
    assert certificate.bounds is not None
    assert kappa > 500.0
    assert kappa <= certificate.bounds.kappa <= 1.02 * kappa


def test_grazing_within_a_micrometre_of_pose_is_no_proof(machine: Machine, prove: Prove, singular_at: float) -> None:
    """Either it is proven and the bound of kappa is huge, or it is refused where it grazes: never a wrong bound."""
    along = singular_at - 1e-6 - 0.8 * (S - 0.5) ** 2
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL)
    certificate = prove(machine, path, (RLL, RLL))
    if certificate.failure is not None:
        assert certificate.failure.s == pytest.approx(0.5, abs=0.02)
    else:
        assert certificate.bounds is not None
        assert certificate.bounds.kappa >= kappa_along(path, np.array([0.5]))[0]


def test_a_path_that_swaps_its_assembly_branch_is_refused_where_it_does(
    machine: Machine, line: Path, prove: Prove
) -> None:
    """The actuators are continuous and every pose closes: only the chain can tell."""
    q = line.q(0.5)
    other = other_solution(machine, q, line.pose(np.array([0.5]))[0])
    swapped = np.array([newton(machine, line.q(s)[None], other[None])[0][0] for s in line.node_s])
    poses = np.where(line.node_s[:, None] < 0.5, line.node_pose, swapped)
    certificate = prove(machine, replace(line, node_pose=poses), least_width=1e-5)
    assert certificate.failure is not None
    assert certificate.failure.s == pytest.approx(0.5, abs=0.05)


def test_a_serial_singularity_is_driven_straight_through(machine: Machine, prove: Prove) -> None:
    """Arm 1 changes from L to R where its discriminant is zero, and nothing happens."""
    before, after = MODES.index("LRR"), MODES.index("RRR")
    solution = inverse_kinematics(machine, _gate(machine, before)[None], np.array([before]), np.array([1]))
    q = solution.q_m[0] + (S - 0.5)[:, None] * np.array([0.1, 0.0, 0.0, 0.0, 0.0])
    path = actuator_path(machine, q, solution.pose[0])
    assert prove(machine, path, (before, after)).verdict == "certified"
    failure = prove(machine, path, (before, before)).failure
    assert failure is not None
    assert failure.reason.text == "at the goal arm 1 is not in working mode LRR"


def test_links_that_come_too_near_are_named(machine: Machine, line: Path, prove: Prove) -> None:
    """A tenth of a millimetre decides, and the place is where they are nearest."""
    s = np.linspace(0.0, 1.0, 2_001)
    distance = link_distances(machine, line.pose(s), line.q(s)[:, :3]).min(axis=1)
    least, where = float(distance.min()), float(s[distance.argmin()])
    assert prove(replace(machine, link_link_m=least - 1e-4), line).verdict == "certified"
    certificate = prove(replace(machine, link_link_m=least + 1e-6), line, least_width=1e-4)
    assert certificate.failure is not None
    assert "are not proven" in certificate.failure.reason.text
    assert certificate.failure.s == pytest.approx(where, abs=0.1)


def test_actuators_that_jump_are_no_path(machine: Machine, line: Path, prove: Prove) -> None:
    """A knot as often as the degree plus one lets a spline jump; rational arithmetic sees a jump of any size."""
    certificate = prove(machine, replace(line, spline=torn(line.spline, 1e-13)))
    assert certificate.failure is not None
    assert certificate.failure.s == 0.5
    assert certificate.failure.reason is ACTUATORS_JUMP


@pytest.mark.parametrize("before", [True, False])
def test_proven_boxes_on_two_branches_do_not_join(machine: Machine, line: Path, before: bool) -> None:
    """Each half holds exactly one pose; a pose at s = 1/2 on either branch lies in one of the two boxes alone."""
    one, other = two_branches(machine, line)
    with working_precision(64):
        for path in (one, other):
            assert close_chain(build_problem(machine, path, 0.3)).failure is None
        jumping = Jumping(machine, one.spline, one.node_s, one.node_pose, beyond=other, before=before)
        chain = close_chain(build_problem(machine, jumping, 0.3))
    assert chain.failure is not None
    assert chain.failure.reason is JUMP
    assert len(chain.inclusions) == (0 if before else 1)


def test_splines_that_are_not_of_zero_to_one_are_no_path(machine: Machine, line: Path, prove: Prove) -> None:
    """A chain from 0 to 1/2 proves nothing about the rest."""
    knots = line.spline.t / 2.0
    certificate = prove(machine, replace(line, spline=BSpline(knots, line.spline.c, 5)))
    assert certificate.failure is not None
    assert certificate.failure.reason is SPLINES_INCOMPLETE


def test_sharpness_is_no_reason_to_refuse(machine: Machine, line: Path, prove: Prove) -> None:
    """However sharp the bound of kappa is wanted: where boxes are not to be halved any more it is what it is."""
    certificate = prove(machine, line, least_width=1e-2, kappa_excess=1e-9)
    assert certificate.verdict == "certified"
    assert 1e-2 <= min(box.last - box.first for box in certificate.chain.boxes) < 2e-2


def _gate(machine: Machine, mode: int) -> np.ndarray:
    """Lower the platform to where arm 1 hangs straight across its rail."""

    def discriminant(z: float) -> float:
        pose = np.array([[1.02, 0.5, z, 0.0, 0.0]])
        return float(inverse_kinematics(machine, pose, np.array([mode])).discriminants_m2[0, 0])

    return np.array([1.02, 0.5, brentq(discriminant, 0.5, 0.8), 0.0, 0.0])


def test_a_chain_of_too_many_boxes_is_refused(
    machine: Machine, line: Path, monkeypatch: pytest.MonkeyPatch, prove: Callable[..., Certificate]
) -> None:
    """It could not be kept: the proof ends there, and says what to change."""
    monkeypatch.setattr(chain, "MOST_BOXES", 2)
    failure = prove(machine, line).failure
    assert failure is not None
    assert failure.reason == chain.TOO_MANY_BOXES
    assert "100,000 boxes" in failure.reason.text
