"""False paths: each breaks a limit so briefly that a few looks do not show it; proof and check refuse all of them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Certificate, Ranges, premises_sha256, prove_path
from pipeline.certify.recheck import Statement, verify
from pipeline.certify.recheck.claims.distances.body_distances import BODIES, OBSTACLES
from pipeline.certify.recheck.claims.joints import angles
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.machine import build_machine
from pipeline.refine import Path
from tests.certify.false_paths.cases import KINDS, LOOKS, Case, draw_case
from tests.certify.paths import ends_of, state

EACH = 5
"""Paths of every kind."""
CLAIM = {
    "a wire on a cart is passed through": BODIES,
    "bodies graze each other": BODIES,
    "a joint leaves its cone": angles.CLAIMS[0],
}
"""What is not verified; of all other kinds the distances from obstacles."""


def proved(config: Config, path: Path) -> Certificate:
    """Prove a path between its own ends."""
    with working_precision(config.certify.precision_bits):
        return prove_path(config, path.machine, path, ends_of(path.machine, path, (0, 0)))


def refused(config: Config, path: Path, stated: Statement) -> list[str]:
    """Name the claims that are not verified."""
    claims = verify(config, path.machine, path, ends_of(path.machine, path, (0, 0)), stated)
    return [claim.what for claim in claims if not claim.verified]


def forged(case: Case, certificate: Certificate) -> Statement:
    """State of the false path what is proven of the harmless one, and as much as is asked for."""
    assert certificate.bounds is not None
    asked, ranges = case.config.machine.clearance.bodies_m, dict(certificate.bounds.ranges)
    for key in ("body_distance_m", "obstacle_distance_m"):
        if key in ranges:
            least = np.maximum(ranges[key].values[:, :1], asked)
            ranges[key] = Ranges(ranges[key].subjects, np.column_stack([least, ranges[key].values[:, 1:]]))
    for cone in build_machine(case.config.machine).joint_cones:
        ranges["joint_angle_deg"] = Ranges((cone.joint,), np.array([[-np.inf, cone.half_angle_deg]]))
    stated = replace(state(certificate), bounds=replace(certificate.bounds, ranges=ranges))
    return replace(stated, premises_sha256=premises_sha256(case.config))


@pytest.mark.parametrize("number", range(EACH))
@pytest.mark.parametrize("kind", KINDS)
def test_a_false_path_is_refused(kind: str, number: int, quick_config: Config) -> None:
    """Where it is false; the harmless one beside it is proven and verified, and forging that helps nothing."""
    case = draw_case(kind, number, quick_config)
    harmless = replace(case.path, machine=build_machine(case.harmless.machine))
    true = proved(case.harmless, harmless)
    assert true.failure is None, true.failure
    assert refused(case.harmless, harmless, state(true)) == []
    failure = proved(case.config, case.path).failure
    assert failure is not None
    assert "not proven" in failure.reason.text
    assert np.abs(case.broken - failure.s).min() < 0.5 / LOOKS
    assert refused(case.config, case.path, forged(case, true)) == [CLAIM.get(kind, OBSTACLES)]
