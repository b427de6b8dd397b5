"""Certificates of machines with bodies: proven, verified again, and refused where bodies come too close."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Certificate, prove_path
from pipeline.certify.bounds import Bounds, Ranges
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck import verify
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims import errors
from pipeline.certify.recheck.claims.distances.body_distances import check, measure
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.result import proven_chain
from pipeline.certify.search import new_search
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.uncertainty import of_actuators
from pipeline.limits import error_proven_limits
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from tests.certify.paths import START, ends_of, pose_path, state

KEY = "body_distance_m"
PATHS = 1
"""Random paths that are tried; thirty were as well."""


@pytest.fixture(scope="module")
def path(bodies_machine: Machine) -> Path:
    """Make a short path in working mode LLL that keeps all bodies apart."""
    return pose_path(bodies_machine, np.linspace(START, [1.05, 0.33, 0.88, -0.05, 0.02], 41), 0)


@pytest.fixture(scope="module")
def prove(bodies_config: Config) -> Callable[[Machine, Path], Certificate]:
    """Give a function that proves a path between its own ends."""
    certify = bodies_config.certify.model_copy(update={"least_width": 4e-3})
    config = bodies_config.model_copy(update={"certify": certify})

    def run(machine: Machine, path: Path) -> Certificate:
        with working_precision(certify.precision_bits):
            return prove_path(config, machine, path, ends_of(machine, path, (0, 0)))

    return run


@pytest.fixture(scope="module")
def proven(bodies_machine: Machine, path: Path, prove) -> Certificate:
    """Prove it."""
    found = prove(bodies_machine, path)
    assert found.failure is None
    return found


def sampled(machine: Machine, path: Path, count: int = 2_001) -> np.ndarray:
    """Measure all pairs along a path, (samples, pairs)."""
    s = np.linspace(0.0, 1.0, count)
    return body_distances(machine.bodies, PoseSamples(machine, path.pose(s), path.q(s)))


@pytest.fixture(scope="module")
def verify_again(bodies_config: Config) -> Callable[[Machine, Path, Certificate], Callable[[Bounds], bool]]:
    """Give a function that evaluates a chain again, and gives another that says whether stated bounds are verified."""

    def evaluate(machine: Machine, path: Path, certificate: Certificate) -> Callable[[Bounds], bool]:
        (segment,) = evaluate_chain(machine, path, certificate.chain)
        evidence = Evidence(bodies_config, machine, measure(bodies_config, machine, segment))
        return lambda stated: all(claim.verified for claim in check(evidence, stated))

    return evaluate


def test_proven_distances_are_below_all_samples(bodies_machine: Machine, path: Path, proven: Certificate) -> None:
    """Of every pair, and by no more than a few millimetres."""
    assert proven.bounds is not None
    ranges, least = proven.bounds.ranges[KEY], sampled(bodies_machine, path).min(axis=0)
    assert bodies_machine.bodies is not None
    assert ranges.subjects == bodies_machine.bodies.names
    assert (ranges.values[:, 0] <= least).all()
    np.testing.assert_allclose(ranges.values[:, 0], np.maximum(least, 0.0), atol=5e-3)


def test_they_are_verified_by_other_arithmetic(bodies_config: Config, path: Path, proven: Certificate) -> None:
    """All claims of the certificate."""
    claims = verify(bodies_config, path.machine, path, ends_of(path.machine, path, (0, 0)), state(proven))
    assert [claim.what for claim in claims if not claim.verified] == []


def test_other_statements_are_refused(bodies_machine: Machine, path: Path, proven: Certificate, verify_again) -> None:
    """A bound above the truth, of other pairs, none at all, or one that does not keep the limit."""
    bounds, verified = proven.bounds, verify_again(bodies_machine, path, proven)
    assert bounds is not None
    assert verified(bounds)
    ranges, others = bounds.ranges[KEY], {key: one for key, one in bounds.ranges.items() if key != KEY}
    larger, smaller = ranges.values.copy(), ranges.values.copy()
    larger[3, 0] += 1e-3
    smaller[smaller[:, 0].argmin(), 0] = 0.004
    for stated in (
        Ranges(ranges.subjects, larger),
        Ranges(ranges.subjects, smaller),
        Ranges(ranges.subjects[::-1], ranges.values),
    ):
        assert not verified(replace(bounds, ranges={**others, KEY: stated}))
    assert not verified(replace(bounds, ranges=others))


def test_brief_grazing_is_refused(bodies_machine: Machine, prove, verify_again) -> None:
    """Paths that come a tenth of a millimetre too close somewhere between their ends; less asked, all hold."""
    rng, refused = np.random.default_rng(2), 0
    bodies = bodies_machine.bodies
    assert bodies is not None
    s = np.linspace(0.0, 1.0, 41)[:, None]
    while refused < PATHS:
        bulge = np.sin(np.pi * s) * rng.uniform(-1.0, 1.0, 5) * [0.0, 0.05, 0.05, 0.1, 0.1]
        path = pose_path(bodies_machine, START + [0.2, 0.0, 0.0, 0.0, 0.0] + bulge + 1e-3 * s, 0)
        distances = sampled(bodies_machine, path, 401)
        least = distances.min(axis=0)
        # The pair that comes nearest between the ends, among those that are not far apart.
        dip = np.minimum(distances[0], distances[-1]) - least
        dip[(least <= 3e-3) | (least > 0.3)] = 0.0
        pair = int(dip.argmax())
        if dip[pair] < 2e-4:
            continue
        refused += 1
        kept, broken = (_of_one_pair(bodies_machine, pair, least[pair] + change) for change in (-2e-3, 1e-4))
        assert prove(kept, path).failure is None
        failure = prove(broken, path).failure
        assert failure is not None
        assert bodies.names[pair] in failure.reason.text
        forged = prove(_of_one_pair(bodies_machine, pair, 0.0), path)
        assert forged.bounds is not None
        assert verify_again(kept, path, forged)(forged.bounds)
        assert not verify_again(broken, path, forged)(forged.bounds)


def _of_one_pair(machine: Machine, pair: int, asked_m: float) -> Machine:
    """Give the machine with one pair of its bodies, to be so far apart."""
    bodies = machine.bodies
    assert bodies is not None
    one = replace(bodies, pairs=(bodies.pairs[pair],), names=(bodies.names[pair],), clearance_m=asked_m)
    return replace(machine, bodies=one)


def test_distances_from_obstacles_are_proven(bodies_config: Config, path: Path, vary) -> None:
    """A workpiece near the path: bounds below all samples, verified again; one in the way refuses the path."""
    centre = [1.05, 0.33, 0.55]
    for size, holds in ((0.1, True), (0.75, False)):
        workpiece = {"name": "workpiece", "box": {"centre_m": centre, "size_m": [size] * 3, "rounding_m": 0.01}}
        config = vary(bodies_config, {"task.obstacles": [workpiece], "certify.least_width": 0.1})
        ends = ends_of(path.machine, path, (0, 0))
        with working_precision(config.certify.precision_bits):
            found = prove_path(config, path.machine, path, ends)
        if not holds:
            assert found.failure is not None
            assert "and workpiece are not proven 0.005 m apart" in found.failure.reason.text
            continue
        assert found.failure is None
        assert found.bounds is not None
        ranges, pairs = found.bounds.ranges["obstacle_distance_m"], obstacles_of(config)
        assert pairs is not None
        s = np.linspace(0.0, 1.0, 501)
        least = body_distances(pairs, PoseSamples(path.machine, path.pose(s), path.q(s))).min(axis=0)
        assert ranges.subjects == pairs.names
        assert (ranges.values[:, 0] <= least).all()
        claims = verify(config, path.machine, path, ends, state(found))
        assert [claim.what for claim in claims if not claim.verified] == []


def test_drives_that_are_off_keep_bodies_apart(bodies_config: Config, bodies_machine: Machine, vary) -> None:
    """What is proven within limits is verified again; with more asked for neither is, though the chain is the same."""
    ends, eps = [START, START + [1e-3, 1e-3, 0.0, 0.0, 0.0]], 3e-4
    path = pose_path(bodies_machine, np.linspace(*ends, 8), 0, nodes=8)
    s = np.linspace(0.0, 1.0, 5)
    nearest = float(body_distances(bodies_machine.bodies, PoseSamples(bodies_machine, path.pose(s), path.q(s))).min())
    given = []
    for short_m in (2e-3, 2e-5):
        config = vary(bodies_config, {"machine.clearance.bodies_m": nearest - short_m})
        given.append((config, build_machine(config.machine)))
    (config, kept), (strict, broken) = given
    kind = of_actuators(np.ones(5))
    with working_precision(64):
        chains = [
            new_search(
                build_problem(machine, path, 0.05), kind, build_error_examiner(error_proven_limits(one, machine)), 0.1
            ).close(eps)
            for one, machine in given
        ]
    assert chains[0].failure is None
    assert chains[1].failure is not None
    assert "m apart" in chains[1].failure.reason.text
    proven = proven_chain(chains[0], kind(eps), within_limits=True)
    (segment,) = evaluate_chain(kept, path, proven)
    assert errors.limit_claim("chain", config, kept, errors.measure(config, kept, segment, None)).verified
    assert not errors.limit_claim("chain", strict, broken, errors.measure(strict, broken, segment, None)).verified
