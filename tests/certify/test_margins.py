"""Margins at the ends of rails and strokes: proven, verified again, and left to the task where it needs them."""

import numpy as np
import pytest

from pipeline.certify import Certificate, prove_path
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.actuators import check, measure
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.route import task_endpoints
from tests.certify.paths import NODES, START, pose_path


@pytest.fixture(scope="module")
def detour(machine: Machine, goal: np.ndarray) -> Path:
    """Go from start to goal by way of smaller x: the first cart comes to within 9 mm of the end of its rail."""
    controlled = np.linspace(START, goal, NODES)
    controlled[:, 0] -= 0.034 * np.sin(np.pi * np.linspace(0.0, 1.0, NODES))
    path = pose_path(machine, controlled, 0)
    assert 0.005 < path.q(np.linspace(0.0, 1.0, 101))[:, 0].min() < 0.015
    return path


def _proven(task: Config, vary, machine: Machine, path: Path, margin_m: float) -> tuple[Config, Certificate]:
    config = vary(task, {"refine.travel_margin_m": margin_m})
    with working_precision(config.certify.precision_bits):
        return config, prove_path(config, machine, path, task_endpoints(config, machine))


def test_a_path_within_a_margin_is_not_certified(own_task: Config, vary, machine: Machine, detour: Path):
    """Although it is on the rail; with less of a margin it is."""
    _, certificate = _proven(own_task, vary, machine, detour, 0.005)
    assert certificate.verdict == "certified"
    _, certificate = _proven(own_task, vary, machine, detour, 0.015)
    assert certificate.verdict == "not certified"
    assert "c1 is not proven to stay within its limits" in certificate.failure.reason.text


def test_what_the_task_needs_is_left_to_it(own_task: Config, vary, machine: Machine, own_path: Path, detour: Path):
    """The start is 20 mm from the end of a rail: a path that comes no nearer keeps a margin of 30 mm."""
    _, certificate = _proven(own_task, vary, machine, own_path, 0.03)
    assert certificate.verdict == "certified"
    _, certificate = _proven(own_task, vary, machine, detour, 0.03)
    assert certificate.verdict == "not certified"


def test_margins_are_verified_again(own_task: Config, vary, machine: Machine, detour: Path):
    """What is stated is held against the range of the configuration that the certificate is checked with."""
    config, certificate = _proven(own_task, vary, machine, detour, 0.005)
    assert certificate.bounds is not None
    (segment,) = evaluate_chain(machine, detour, certificate.chain)
    for margin_m, verified in ((0.005, True), (0.015, False), (0.03, False)):
        asked = vary(config, {"refine.travel_margin_m": margin_m})
        evidence = Evidence(asked, machine, measure(asked, machine, segment))
        (claim,) = check(evidence, certificate.bounds)
        assert claim.verified == verified
        assert f"limits {min(margin_m, 0.0201727):g} to" in claim.found
