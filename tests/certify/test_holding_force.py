"""The certificate's bounds of the forces that hold the machine, and their independent check."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from pipeline.certify import Certificate, Ranges
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.recheck.claims.gravity.holding_force import check, holding_force_bounds, measure
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.refine.measure import sample_path
from tests.certify.paths import RLL, START, TOWARDS_SINGULARITY, pose_path

KEY = "holding_force_n"


@pytest.fixture(scope="module")
def held(machine: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Prove the short path with force limits."""
    return prove(machine, line, held=True)


@pytest.fixture(scope="module")
def evidence(agder_config: Config, machine: Machine, line: Path, held: Certificate) -> Evidence:
    """Evaluate the boxes of the short path again."""
    (segment,) = evaluate_chain(machine, line, held.chain)
    return Evidence(agder_config, machine, measure(agder_config, machine, segment))


def _stating(certificate: Certificate, bounds_n: np.ndarray) -> object:
    assert certificate.bounds is not None
    ranges = Ranges(certificate.bounds.ranges[KEY].subjects, bounds_n)
    return replace(certificate.bounds, ranges={**certificate.bounds.ranges, KEY: ranges})


def _sampled(path: Path) -> np.ndarray:
    """Least and largest force at samples, shape (11, 2)."""
    forces = sample_path(path, np.linspace(0.0, 1.0, 4_001)).holding_forces_n
    return np.stack([forces.min(axis=0), forces.max(axis=0)], axis=1)


def _within(ranges: np.ndarray, of: np.ndarray) -> bool:
    return bool((of[:, 0] <= ranges[:, 0]).all() and (ranges[:, 1] <= of[:, 1]).all())


def test_bounds_hold_at_samples_and_are_sharp(line: Path, held: Certificate):
    """No sample exceeds them, and they exceed no sample by more than a few newtons."""
    assert held.verdict == "certified"
    assert held.bounds is not None
    sampled, bounds = _sampled(line), held.bounds.ranges[KEY].values
    assert _within(sampled, bounds)
    assert (np.abs(bounds - sampled) <= 0.02 * np.abs(sampled).max(axis=1, keepdims=True) + 5.0).all()


def test_bounds_hold_near_a_singularity(machine: Machine, singular_at: float, prove: Callable[..., Certificate]):
    """Forces grow without limit there; what is proven stays above them."""
    along = singular_at * np.linspace(0.9, 0.97, 41)
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL)
    strong = replace(machine, force_n=np.full(5, 1e9), link_force_n=1e9)
    certificate = prove(strong, path, (RLL, RLL), held=True, kappa_excess=1.0)
    assert certificate.verdict == "certified"
    assert certificate.bounds is not None
    sampled, bounds = _sampled(path), certificate.bounds.ranges[KEY].values
    assert _within(sampled, bounds)
    assert np.abs(sampled).max() > 1_000.0
    found = holding_force_bounds(strong, strong.masses, *_boxes(strong, path, certificate))
    assert _within(sampled, found)
    assert _within(found, bounds)


def _boxes(machine: Machine, path: Path, certificate: Certificate) -> tuple:
    (segment,) = evaluate_chain(machine, path, certificate.chain)
    return segment.boxes, segment.inclusions.image


def test_other_arithmetic_finds_the_same(machine: Machine, line: Path, held: Certificate):
    """Wider than all samples, within what is stated."""
    found = holding_force_bounds(machine, machine.masses, *_boxes(machine, line, held))
    assert held.bounds is not None
    assert _within(_sampled(line), found)
    assert _within(found, held.bounds.ranges[KEY].values)


def test_what_is_stated_is_verified(held: Certificate, evidence: Evidence):
    """Bounds that are too small, too large for the machine, or missing are not verified."""
    assert held.bounds is not None
    stated = held.bounds.ranges[KEY].values
    (claim,) = check(evidence, held.bounds)
    assert claim.verified
    for side in (0, 1):
        narrow, wide = stated.copy(), evidence.machine.force_limits_n.copy()
        narrow[:, side] -= 0.01 * np.abs(stated).max(axis=1) * (-1.0) ** (side + 1)
        (claim,) = check(evidence, _stating(held, narrow))
        assert not claim.verified
        # Push is positive: the largest force, but the first limit.
        k = int((stated[:5, 1] if side else -stated[:5, 0]).argmax())
        wide[1 - side, k] = 0.99 * abs(stated[k, side])
        (claim,) = check(replace(evidence, machine=replace(evidence.machine, force_n=wide[:, :5])), held.bounds)
        assert not claim.verified
    (claim,) = check(evidence, replace(held.bounds, ranges={}))
    assert not claim.verified
    assert "before forces were bounded" in claim.found


def test_a_machine_that_is_too_weak_is_not_certified(
    machine: Machine, line: Path, held: Certificate, prove: Callable[..., Certificate]
):
    """The drive is named; a little above what it needs is enough, since boxes are halved until bounds are sharp."""
    largest = np.abs(sample_path(line, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    for factor, verdict in ((0.999, "not certified"), (1.003, "certified")):
        weak = replace(machine, force_n=np.append(np.full(3, np.inf), factor * largest[3:5]))
        certificate = prove(weak, line, held=True, least_width=1e-6)
        assert certificate.verdict == verdict
        if certificate.failure is not None:
            assert "is not proven to hold the machine" in certificate.failure.reason.text


@pytest.mark.parametrize("side", [0, 1])
def test_push_and_pull_have_limits_of_their_own(
    machine: Machine, line: Path, prove: Callable[..., Certificate], side: int
):
    """Each is refused a little below what it needs, however much the other may take."""
    least, largest = _sampled(line).T
    needs = np.stack([largest, -least])[:, :5]
    drive = int(needs[side].argmax())
    for factor, verdict in ((0.999, "not certified"), (1.003, "certified")):
        force = np.full((2, 5), 1e6)
        force[side, drive] = factor * needs[side, drive]
        weak = replace(machine, force_n=force)
        assert prove(weak, line, held=True, least_width=1e-6).verdict == verdict


def test_friction_carries_part_of_it(machine: Machine, line: Path, prove: Callable[..., Certificate]):
    """At rest: what gravity takes more than the limit, friction may hold."""
    largest = np.abs(sample_path(line, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    weak = replace(machine, force_n=np.append(np.full(3, np.inf), largest[3:5] - 10.0))
    assert prove(weak, line, held=True, least_width=1e-5).verdict == "not certified"
    rubbing = replace(weak, masses=replace(machine.masses, friction_n=np.full(5, 15.0)))
    assert prove(rubbing, line, held=True).verdict == "certified"


def test_what_is_stated_of_wide_boxes_is_verified(machine: Machine, prove: Callable[..., Certificate]):
    """Both arithmetics overestimate forces over wide boxes, not quite alike: what is stated leaves room for that."""
    poses = START + np.array(
        [
            [0.0, 0.0, 0.0, 0.0, 0.0],
            [0.28, 0.15, -0.15, 0.15, -0.1],
            [0.08, 0.3, -0.1, -0.1, 0.2],
            [-0.22, 0.05, 0.1, 0.1, 0.1],
            [-0.02, -0.05, -0.1, 0.0, -0.15],
            [0.0, 0.0, 0.0, 0.0, 0.0],
        ]
    )
    curve = CubicSpline(np.linspace(0.0, 1.0, len(poses)), poses)(np.linspace(0.0, 1.0, 30))
    wide = replace(machine, travel_m=np.tile([-5.0, 5.0], (3, 1)), strokes_m=np.tile([0.5, 2.0], (2, 1)))
    path = pose_path(wide, curve, 0, nodes=30)
    certificate = prove(wide, path, held=True)
    assert certificate.verdict == "certified"
    found = holding_force_bounds(wide, wide.masses, *_boxes(wide, path, certificate))
    assert _within(found, certificate.bounds.ranges[KEY].values)
