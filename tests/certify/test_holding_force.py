"""The certificate's bounds of the forces that hold the machine, and their independent check."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Certificate, Ranges
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.recheck.claims.holding_force import check, holding_force_bounds, measure
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
    return Evidence(agder_config, machine, measure(machine, segment))


def _stating(certificate: Certificate, largest_n: np.ndarray) -> object:
    assert certificate.bounds is not None
    ranges = Ranges(certificate.bounds.ranges[KEY].subjects, np.column_stack([np.full(11, -np.inf), largest_n]))
    return replace(certificate.bounds, ranges={**certificate.bounds.ranges, KEY: ranges})


def test_bounds_hold_at_samples_and_are_sharp(line: Path, held: Certificate):
    """No sample exceeds them, and they exceed no sample by more than a few newtons."""
    assert held.verdict == "certified"
    assert held.bounds is not None
    largest = np.abs(sample_path(line, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    bounds = held.bounds.ranges[KEY].values[:, 1]
    assert (bounds >= largest).all()
    assert (bounds <= 1.02 * largest + 5.0).all()


def test_bounds_hold_near_a_singularity(machine: Machine, singular_at: float, prove: Callable[..., Certificate]):
    """Forces grow without limit there; what is proven stays above them."""
    along = singular_at * np.linspace(0.9, 0.97, 41)
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL)
    strong = replace(machine, force_n=np.full(5, 1e9), link_force_n=1e9)
    certificate = prove(strong, path, (RLL, RLL), held=True, kappa_excess=1.0)
    assert certificate.verdict == "certified"
    assert certificate.bounds is not None
    largest = np.abs(sample_path(path, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    bounds = certificate.bounds.ranges[KEY].values[:, 1]
    assert (bounds >= largest).all()
    assert largest.max() > 1_000.0
    found = holding_force_bounds(strong, strong.masses, *_boxes(strong, path, certificate))
    assert (found >= largest).all()
    assert (found <= bounds).all()


def _boxes(machine: Machine, path: Path, certificate: Certificate) -> tuple:
    (segment,) = evaluate_chain(machine, path, certificate.chain)
    return segment.boxes, segment.inclusions.image


def test_other_arithmetic_finds_the_same(machine: Machine, line: Path, held: Certificate):
    """Above every sample, below what is stated."""
    found = holding_force_bounds(machine, machine.masses, *_boxes(machine, line, held))
    largest = np.abs(sample_path(line, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    assert held.bounds is not None
    assert (found >= largest).all()
    assert (found <= held.bounds.ranges[KEY].values[:, 1]).all()


def test_what_is_stated_is_verified(held: Certificate, evidence: Evidence):
    """Bounds that are too small, too large for the machine, or missing are not verified."""
    assert held.bounds is not None
    stated = held.bounds.ranges[KEY].values[:, 1]
    (claim,) = check(evidence, held.bounds)
    assert claim.verified
    (claim,) = check(evidence, _stating(held, 0.99 * stated))
    assert not claim.verified
    weak = replace(evidence, machine=replace(evidence.machine, force_n=np.full(5, 0.99 * stated[:5].max())))
    (claim,) = check(weak, held.bounds)
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


def test_friction_carries_part_of_it(machine: Machine, line: Path, prove: Callable[..., Certificate]):
    """At rest: what gravity takes more than the limit, friction may hold."""
    largest = np.abs(sample_path(line, np.linspace(0.0, 1.0, 4_001)).holding_forces_n).max(axis=0)
    weak = replace(machine, force_n=np.append(np.full(3, np.inf), largest[3:5] - 10.0))
    assert prove(weak, line, held=True, least_width=1e-5).verdict == "not certified"
    rubbing = replace(weak, masses=replace(machine.masses, friction_n=np.full(5, 15.0)))
    assert prove(rubbing, line, held=True).verdict == "certified"
