"""A certificate verified again: a good one passes, and whatever is changed about it is found."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.certify import Certificate
from pipeline.certify.limits import Limits, build_limits
from pipeline.certify.recheck import MANDATORY, Claim, verify
from pipeline.certify.result import Bounds, ProvenChain
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import branching_chains, ends_of, state, torn, two_branches, verified

Verify = Callable[..., list[Claim]]


@pytest.fixture(scope="module")
def certificate(machine: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Certify the short path."""
    return prove(machine, line)


@pytest.fixture(scope="module")
def limits(wide: Config, machine: Machine) -> Limits:
    """Take the limits of the tests."""
    return build_limits(wide, replace(machine, link_link_m=0.0), 0.0)


@pytest.fixture(scope="module")
def check(machine: Machine, line: Path, limits: Limits, certificate: Certificate) -> Verify:
    """Give a function that verifies the certificate with changes, and lists what does not hold."""

    def run(**changes: object) -> list[Claim]:
        given: dict[str, Any] = {"path": line, "machine": machine, "limits": limits, "stated": state(certificate)}
        given.update({key: value for key, value in changes.items() if key in given})
        stated = replace(given["stated"], **{key: value for key, value in changes.items() if key not in given})
        ends = ends_of(machine, line, (0, 0))
        premises = certificate.premises_sha256
        claims = verify(given["machine"], given["path"], given["limits"], ends, premises, stated)
        assert {claim.what for claim in claims} >= set(MANDATORY)
        return [claim for claim in claims if not claim.verified]

    return run


def test_a_certificate_is_verified(check: Verify) -> None:
    """Every claim, by other code in other arithmetic."""
    assert check() == []


def _one_box(chain: ProvenChain, **changes: object) -> ProvenChain:
    k = len(chain.boxes) // 2
    box = replace(chain.boxes[k], **changes)
    return replace(chain, boxes=(*chain.boxes[:k], box, *chain.boxes[k + 1 :]))


CHAINS: dict[str, Callable[[ProvenChain], ProvenChain]] = {
    "a radius that is too small": lambda chain: _one_box(chain, radius=np.full(6, 1e-15)),
    "a radius that is too large": lambda chain: _one_box(chain, radius=np.full(6, 3.0)),
    "no radius": lambda chain: _one_box(chain, radius=np.zeros(6)),
    "a radius that is no number": lambda chain: _one_box(chain, radius=np.full(6, np.nan)),
    "a cubic beside the path": lambda chain: _one_box(chain, pose=chain.boxes[0].pose),
    "a box left out": lambda chain: replace(chain, boxes=chain.boxes[1:], joints=chain.joints[1:]),
    "the last box left out": lambda chain: replace(chain, boxes=chain.boxes[:-1], joints=chain.joints[:-1]),
    "a gap": lambda chain: _one_box(chain, last=chain.boxes[len(chain.boxes) // 2].last - 1e-9),
    "a joint elsewhere": lambda chain: replace(chain, joints=chain.joints[::-1]),
}


@pytest.mark.parametrize("name", CHAINS)
def test_a_chain_that_was_changed_is_found(check: Verify, certificate: Certificate, name: str) -> None:
    """One box is enough."""
    assert check(chains=(CHAINS[name](certificate.chain),))


BOUNDS: dict[str, Callable[[Bounds], Bounds]] = {
    "kappa beyond the cap": lambda bounds: replace(bounds, kappa=2e9),
    "distances that are none": lambda bounds: replace(bounds, distances_m=bounds.distances_m - 1.0),
    "travel beyond the limits": lambda bounds: replace(bounds, actuators_m=bounds.actuators_m + [-9.0, 9.0]),
    "tilts beyond the limits": lambda bounds: replace(bounds, tilt_rad=bounds.tilt_rad + 1.5),
    "ends that are missed": lambda bounds: replace(bounds, start_miss=1e-3),
    "kappa": lambda bounds: replace(bounds, kappa=0.98 * bounds.kappa),
    "det_sign": lambda bounds: replace(bounds, det_sign=-bounds.det_sign),
    "no det_sign": lambda bounds: replace(bounds, det_sign=0),
    "distances_m": lambda bounds: replace(bounds, distances_m=bounds.distances_m + 2e-3),
    "pairs": lambda bounds: replace(bounds, pairs=bounds.pairs[::-1]),
    "actuators_m": lambda bounds: replace(bounds, actuators_m=bounds.actuators_m + [1e-4, 0.0]),
    "tilt_rad": lambda bounds: replace(bounds, tilt_rad=0.99 * bounds.tilt_rad),
    "goal_miss": lambda bounds: replace(bounds, goal_miss=-1.0),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_a_bound_that_was_changed_is_found(check: Verify, certificate: Certificate, name: str) -> None:
    """Claiming more than is true."""
    assert certificate.bounds is not None
    assert check(bounds=BOUNDS[name](certificate.bounds))


def test_whatever_is_not_there_is_asked_for(check: Verify) -> None:
    """Without a chain every claim that needs one fails, not only that there is none."""
    missing = {claim.what for claim in check(chains=())}
    assert missing >= {what for what in MANDATORY if "machine: " in what or "kappa" in what or "the start is" in what}


def test_boxes_on_two_branches_are_found(machine: Machine, line: Path) -> None:
    """Each is proven, their joint too, and they reach from 0 to 1: only that neighbours share a branch is wrong."""
    for chain in branching_chains(machine, line):
        claims = verified(machine, two_branches(machine, line)[0], chain)
        assert claims["boxes reach from s = 0 to 1"]
        assert claims["each holds one pose, regular"]
        assert not claims["neighbours share a branch"]


def test_splines_that_jump_are_not_computed_with(check: Verify, line: Path) -> None:
    """Nothing is said about boxes along what is no function."""
    missing = {claim.what for claim in check(path=replace(line, spline=torn(line.spline, 1.0)))}
    assert "the splines are continuous from s = 0 to 1" in missing
    assert "configured machine: each holds one pose, regular" in missing


def test_another_path_or_machine_is_found(check: Verify, machine: Machine, line: Path) -> None:
    """By its hash, and by the boxes it does not go through."""
    spline = line.spline
    other = replace(line, spline=type(spline)(spline.t, spline.c + 1e-4, spline.k))
    assert {claim.what for claim in check(path=other)} >= {"it is about this path"}
    longer = replace(machine, lengths_m=machine.lengths_m + 1e-4)
    assert check(machine=longer)


def test_limits_that_are_stricter_are_found(check: Verify, limits: Limits) -> None:
    """The configuration beside the certificate is what counts."""
    assert check(limits=replace(limits, kappa_max=10.0))
    assert check(limits=replace(limits, link_link_m=0.5))
    assert check(limits=replace(limits, tilt_rad=np.array([0.01, 0.01])))
