"""A certificate verified again: a true one passes, and any change to it is found."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.certify import Bounds, Certificate, Ranges, premises_sha256
from pipeline.certify.recheck import MANDATORY, Claim, verify
from pipeline.certify.recheck.claims.checks import CHECKS
from pipeline.certify.result import ProvenChain
from pipeline.config import Config
from pipeline.limits import certificate_keys
from pipeline.machine import Machine
from pipeline.refine import Path
from tests.certify.paths import branching_chains, ends_of, state, torn, two_branches, verified

Verify = Callable[..., list[Claim]]


@pytest.fixture(scope="module")
def certificate(machine: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Certify the short path."""
    return prove(machine, line, held=True)


@pytest.fixture(scope="module")
def free(machine: Machine) -> Machine:
    """Take the machine without a least distance of links."""
    return replace(machine, link_link_m=0.0)


@pytest.fixture(scope="module")
def check(wide: Config, free: Machine, line: Path, certificate: Certificate) -> Verify:
    """Give a function that verifies the certificate with changes, and lists what does not hold."""

    def run(**changes: object) -> list[Claim]:
        given: dict[str, Any] = {"config": wide, "path": line, "machine": free, "stated": state(certificate)}
        given.update({key: value for key, value in changes.items() if key in given})
        stated = replace(given["stated"], **{key: value for key, value in changes.items() if key not in given})
        claims = verify(given["config"], given["machine"], given["path"], ends_of(free, line, (0, 0)), stated)
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


def _with(key: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Bounds], Bounds]:
    """Change the values of one key."""

    def changed(bounds: Bounds) -> Bounds:
        ranges = replace(bounds.ranges[key], values=change(bounds.ranges[key].values))
        return replace(bounds, ranges={**bounds.ranges, key: ranges})

    return changed


def _pairs_reversed(bounds: Bounds) -> Bounds:
    ranges = replace(bounds.ranges["distance_m"], subjects=bounds.pairs[::-1])
    return replace(bounds, ranges={**bounds.ranges, "distance_m": ranges})


BOUNDS: dict[str, Callable[[Bounds], Bounds]] = {
    "kappa beyond the cap": _with("kappa", lambda values: np.array([[-np.inf, 2e9]])),
    "distances that are none": _with("distance_m", lambda values: values - 1.0),
    "travel beyond the limits": _with("actuators_m", lambda values: values + [-9.0, 9.0]),
    "tilts beyond the limits": _with("tilt_deg", lambda values: values + np.rad2deg(1.5)),
    "ends that are missed": lambda bounds: replace(bounds, start_miss=1e-3),
    "kappa": _with("kappa", lambda values: 0.98 * values),
    "det_sign": _with("det_sign", lambda values: -values),
    "no det_sign": _with("det_sign", lambda values: np.array([[-1.0, 1.0]])),
    "distances_m": _with("distance_m", lambda values: values + 2e-3),
    "pairs": _pairs_reversed,
    "actuators_m": _with("actuators_m", lambda values: values + [1e-4, 0.0]),
    "tilt_deg": _with("tilt_deg", lambda values: 0.99 * values),
    "goal_miss": lambda bounds: replace(bounds, goal_miss=-1.0),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_a_bound_that_was_changed_is_found(check: Verify, certificate: Certificate, name: str) -> None:
    """Claiming more than is true."""
    assert certificate.bounds is not None
    assert check(bounds=BOUNDS[name](certificate.bounds))


def test_whatever_is_not_there_is_asked_for(check: Verify) -> None:
    """Without a chain every claim that needs one fails, not only the one that counts chains."""
    missing = {claim.what for claim in check(chains=())}
    assert missing >= {what for what in MANDATORY if "machine: " in what or "kappa" in what or "the start is" in what}


def test_a_bound_that_nothing_checks_is_not_verified(check: Verify, certificate: Certificate) -> None:
    """A key that no module of `claims` knows is refused, whatever it states."""
    assert certificate.bounds is not None
    ranges = {**certificate.bounds.ranges, "force_n": Ranges(("l1",), np.array([[-np.inf, 1e9]]))}
    wrong = check(bounds=replace(certificate.bounds, ranges=ranges))
    assert [claim.what for claim in wrong] == ["bounds.force_n can be verified"]


def test_every_key_of_a_certificate_has_a_check() -> None:
    """Each proven kind of limit is verified by exactly one module."""
    checked = [key for module in CHECKS for key in module.KEYS]
    assert sorted(checked) == sorted(key.name for key in certificate_keys())


def test_boxes_on_two_branches_are_found(wide: Config, machine: Machine, line: Path) -> None:
    """Each is proven, their joint too, and they reach from 0 to 1: only that neighbours share a branch is wrong."""
    for chain in branching_chains(machine, line):
        claims = verified(wide, two_branches(machine, line)[0], chain)
        assert claims["boxes cover s = 0 to 1"]
        assert claims["each box holds one regular pose"]
        assert not claims["neighbouring boxes share a branch"]


def test_splines_that_jump_are_not_computed_with(check: Verify, line: Path) -> None:
    """Nothing is said about boxes along what is no function."""
    missing = {claim.what for claim in check(path=replace(line, spline=torn(line.spline, 1.0)))}
    assert "the splines are continuous from s = 0 to 1" in missing
    assert "configured machine: each box holds one regular pose" in missing


def test_another_path_or_machine_is_found(check: Verify, free: Machine, line: Path) -> None:
    """By its hash, and by the boxes it does not go through."""
    spline = line.spline
    other = replace(line, spline=type(spline)(spline.t, spline.c + 1e-4, spline.k))
    assert {claim.what for claim in check(path=other)} >= {"the certificate is of this path"}
    longer = replace(free, lengths_m=free.lengths_m + 1e-4)
    assert check(machine=longer)


STRICTER: dict[str, tuple[dict[str, dict[str, Any]], str]] = {
    "cap": ({"route": {"kappa_max": 10.0}}, "kappa stays below its bound, within the cap"),
    "tilt": ({"task": {"tilt_max_deg": 0.5}}, "tilts stay within bounds and limits"),
}


@pytest.mark.parametrize("name", STRICTER)
def test_limits_that_are_stricter_are_found(check: Verify, wide: Config, certificate: Certificate, name: str) -> None:
    """The configuration beside the certificate is what counts, even with the hash of its premises forged."""
    changes, claim = STRICTER[name]
    sections = {section: getattr(wide, section).model_copy(update=change) for section, change in changes.items()}
    config = wide.model_copy(update=sections)
    assert [one.what for one in check(config=config, premises_sha256=premises_sha256(config))] == [claim]


def test_distances_that_are_stricter_are_found(check: Verify, free: Machine) -> None:
    """Links have to be as far apart as the machine asks for, and rails are not left out."""
    for strict in (replace(free, link_link_m=0.5), replace(free, link_rail_m=0.0)):
        assert [claim.what for claim in check(machine=strict)] == ["axes keep their required distances"]


def test_forces_that_are_stricter_are_found(check: Verify, free: Machine) -> None:
    """The machine that is asked about has to be strong enough."""
    weak = replace(free, holding_fraction=0.2)
    assert [claim.what for claim in check(machine=weak)] == ["drives and links hold the machine within their limits"]
