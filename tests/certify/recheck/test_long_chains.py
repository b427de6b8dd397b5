"""Chains of more boxes than are evaluated at a time: segments change nothing but memory."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Certificate, certify_path
from pipeline.certify.recheck import Claim, kappa_profile, profile, verify
from pipeline.certify.recheck.arithmetic import chain
from pipeline.certify.result import ProvenChain
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.route.regions.endpoints import task_endpoints
from tests.certify.paths import state

Verify = Callable[[ProvenChain], list[Claim]]


@pytest.fixture(scope="module")
def certificate(own_task: Config, machine: Machine, own_path: Path) -> Certificate:
    """Certify the path from the start to the goal."""
    found = certify_path(own_task, machine, own_path)
    assert len(found.chain.boxes) > 9
    return found


@pytest.fixture(scope="module")
def claims(own_task: Config, machine: Machine, own_path: Path, certificate: Certificate) -> Verify:
    """Give a function that verifies the certificate with another chain."""

    def run(other: ProvenChain) -> list[Claim]:
        stated = state(replace(certificate, chain=other))
        return verify(own_task, machine, own_path, task_endpoints(own_task, machine), stated)

    return run


def _cut(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    for module in (chain, profile):
        monkeypatch.setattr(module, "SEGMENT", size)


def test_claims_are_the_same_in_segments(
    certificate: Certificate, claims: Verify, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With whatever was found, of a genuine chain and of one with wrong boxes where segments begin and end."""
    boxes = list(certificate.chain.boxes)
    for k in (7, 8, len(boxes) - 1):
        boxes[k] = replace(boxes[k], pose=boxes[k].pose + 1e-3 * (np.arange(4)[:, None] == 0))
    wrong = replace(certificate.chain, boxes=tuple(boxes))
    whole = [claims(certificate.chain), claims(wrong)]
    _cut(monkeypatch, 8)
    assert [claims(certificate.chain), claims(wrong)] == whole
    assert all(claim.verified for claim in whole[0])
    found = {claim.what: claim.found for claim in whole[1] if not claim.verified}
    assert found["configured machine: each box holds one regular pose"] == f"{len(boxes) - 3} of {len(boxes)}"


def test_the_profile_is_the_same_in_segments(
    machine: Machine, own_path: Path, certificate: Certificate, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every box once, in order."""
    whole = kappa_profile(machine, own_path, certificate.chain)
    _cut(monkeypatch, 4)
    parts = kappa_profile(machine, own_path, certificate.chain)
    np.testing.assert_array_equal(parts.edges, whole.edges)
    np.testing.assert_allclose(parts.kappa, whole.kappa, rtol=1e-12)
