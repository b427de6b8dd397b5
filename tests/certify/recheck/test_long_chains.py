"""Chains of more boxes than are evaluated at a time: segments change nothing but memory and when it ends."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import Bounds, Certificate, certify_path
from pipeline.certify.recheck import MANDATORY, Claim, kappa_profile, profile, verify
from pipeline.certify.recheck.arithmetic import chain
from pipeline.certify.recheck.claims.chain import CLAIMS
from pipeline.certify.result import ProvenChain
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.route.regions.endpoints import task_endpoints
from tests.certify.paths import state

Verify = Callable[..., list[Claim]]


@pytest.fixture(scope="module")
def certificate(own_task: Config, machine: Machine, own_path: Path) -> Certificate:
    """Certify the path from the start to the goal."""
    found = certify_path(own_task, machine, own_path)
    assert len(found.chain.boxes) > 9
    return found


@pytest.fixture(scope="module")
def claims(own_task: Config, machine: Machine, own_path: Path, certificate: Certificate) -> Verify:
    """Give a function that verifies the certificate with another chain."""

    def run(other: ProvenChain, bounds: Bounds | None = certificate.bounds) -> list[Claim]:
        stated = state(replace(certificate, chain=other, bounds=bounds))
        return verify(own_task, machine, own_path, task_endpoints(own_task, machine), stated)

    return run


def _narrowed(proven: ProvenChain, k: int) -> ProvenChain:
    """Give the chain with one box that proves nothing, being too narrow."""
    boxes = list(proven.boxes)
    boxes[k] = replace(boxes[k], radius=np.full(6, 1e-15))
    return replace(proven, boxes=tuple(boxes))


def _cut(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    for module in (chain, profile):
        monkeypatch.setattr(module, "SEGMENT", size)


def test_claims_are_the_same_in_segments(
    certificate: Certificate, claims: Verify, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With whatever was found, of a genuine chain and of one whose last box is wrong."""
    wrong = _narrowed(certificate.chain, len(certificate.chain.boxes) - 1)
    whole = [claims(certificate.chain), claims(wrong)]
    _cut(monkeypatch, 8)
    assert [claims(certificate.chain), claims(wrong)] == whole
    assert all(claim.verified for claim in whole[0])
    boxes = len(wrong.boxes)
    found = {claim.what: claim.found for claim in whole[1] if not claim.verified}
    assert found["configured machine: each box holds one regular pose"] == f"{boxes - 1} of {boxes}"


def test_nothing_is_evaluated_after_what_is_wrong(
    certificate: Certificate, claims: Verify, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A box, an end, a bound: the rest of a long chain is not evaluated, and none of what depends on it verified."""
    _cut(monkeypatch, 4)
    bounds = certificate.bounds
    assert bounds is not None
    kappa = replace(bounds.ranges["kappa"], values=bounds.ranges["kappa"].values * 0.5)
    for other, stated in (
        (_narrowed(certificate.chain, 2), bounds),
        (replace(certificate.chain, boxes=certificate.chain.boxes[:-1]), bounds),
        (certificate.chain, replace(bounds, ranges={**bounds.ranges, "kappa": kappa})),
        (certificate.chain, replace(bounds, goal_miss=0.0)),
    ):
        found = claims(other, stated)
        wrong = {claim.what: claim.found for claim in found if not claim.verified}
        assert wrong.keys() >= {f"configured machine: {what}" for what in CLAIMS[1:]}
        assert wrong[f"configured machine: {CLAIMS[1]}"].endswith(f"of the first 4 of {len(other.boxes)}")
        assert {claim.what for claim in found} >= set(MANDATORY)


def test_the_profile_is_the_same_in_segments(
    machine: Machine, own_path: Path, certificate: Certificate, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every box once, in order."""
    whole = kappa_profile(machine, own_path, certificate.chain)
    _cut(monkeypatch, 4)
    parts = kappa_profile(machine, own_path, certificate.chain)
    np.testing.assert_array_equal(parts.edges, whole.edges)
    np.testing.assert_allclose(parts.kappa, whole.kappa, rtol=1e-12)
