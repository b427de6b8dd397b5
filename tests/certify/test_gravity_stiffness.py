"""The certificate's bound of the stiffness that gravity gives, and its independent check."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.artifacts.results.certificate.bounds import read_bounds, state_bounds
from pipeline.certify import Bounds, Certificate, Ranges
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.recheck.claims.gravity.stiffness import check, measure
from pipeline.config import Config
from pipeline.limits import certificate_keys
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.refine.measure import sample_path

KEY = "gravity_stiffness_npm"


@pytest.fixture(scope="module")
def least(line: Path) -> float:
    """Sample the least stiffness along the short path."""
    return float(sample_path(line, np.linspace(0.0, 1.0, 4_001)).gravity_stiffness_npm.min())


@pytest.fixture(scope="module")
def soft(machine: Machine, least: float) -> Machine:
    """Take a machine that may be somewhat less stable than it is."""
    return replace(machine, gravity_stiffness_npm=1.1 * least)


@pytest.fixture(scope="module")
def held(soft: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Prove the short path with that limit."""
    return prove(soft, line, held=True)


@pytest.fixture(scope="module")
def evidence(agder_config: Config, soft: Machine, line: Path, held: Certificate) -> Evidence:
    """Evaluate the boxes of the short path again."""
    (segment,) = evaluate_chain(soft, line, held.chain)
    return Evidence(agder_config, soft, measure(agder_config, soft, segment))


def _stating(certificate: Certificate, least_npm: float) -> Bounds:
    assert certificate.bounds is not None
    ranges = Ranges((KEY,), np.array([[least_npm, np.inf]]))
    return replace(certificate.bounds, ranges={**certificate.bounds.ranges, KEY: ranges})


def test_the_bound_holds_at_samples(held: Certificate, least: float, soft: Machine) -> None:
    """It is between the limit and every sample."""
    assert held.verdict == "certified"
    assert held.bounds is not None
    proven, _ = held.bounds.ranges[KEY].values[0]
    assert soft.gravity_stiffness_npm <= proven <= least


def test_it_is_written_and_read(held: Certificate) -> None:
    """As a number that may be negative."""
    assert held.bounds is not None
    keys = [key for key in certificate_keys() if key.name in held.bounds.ranges]
    stated = state_bounds(held.bounds, keys)
    assert stated[KEY] < 0.0
    np.testing.assert_array_equal(read_bounds(stated, keys).ranges[KEY].values, held.bounds.ranges[KEY].values)


def test_what_is_stated_is_verified(held: Certificate, evidence: Evidence) -> None:
    """Bounds that are too high, below the limit, or missing are not verified; nor is one that is not asked for."""
    assert held.bounds is not None
    (claim,) = check(evidence, held.bounds)
    assert claim.verified
    for wrong in (float(evidence.least[0]) + 1.0, evidence.machine.gravity_stiffness_npm - 1.0):
        (claim,) = check(evidence, _stating(held, wrong))
        assert not claim.verified
    without = replace(held.bounds, ranges={k: v for k, v in held.bounds.ranges.items() if k != KEY})
    (claim,) = check(evidence, without)
    assert not claim.verified
    free = replace(evidence, machine=replace(evidence.machine, gravity_stiffness_npm=-np.inf), found=np.empty((0, 2)))
    (claim,) = check(free, held.bounds)
    assert not claim.verified
    (claim,) = check(free, without)
    assert claim.verified


def test_a_limit_above_it_is_not_certified(
    machine: Machine, line: Path, least: float, prove: Callable[..., Certificate]
) -> None:
    """A little below what the path has is enough, since boxes are halved until bounds are sharp."""
    for factor, verdict in ((0.999, "not certified"), (1.003, "certified")):
        soft = replace(machine, gravity_stiffness_npm=factor * least)
        certificate = prove(soft, line, held=True, least_width=1e-5)
        assert certificate.verdict == verdict
        if certificate.failure is not None:
            assert "gravity stiffness is not proven to be at least" in certificate.failure.reason.text
