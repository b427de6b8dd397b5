"""The certificate's bounds of joint angles, and their independent check."""

import pathlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.certify import Certificate, certify_path
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.evidence import Evidence, upper_bounds
from pipeline.certify.recheck.claims.joints.angles import angles_above_deg, check, joint_cosines
from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits.joint_cone import joint_angles_deg
from pipeline.machine import Machine, build_machine
from pipeline.machine.joints.cone import JointCone
from pipeline.refine import Path, refine_path
from pipeline.refine.measure import sample_path
from pipeline.route import build_regions, plan_route
from tests.certify.paths import START, pose_path
from tests.certify.runs import Data, forge, write_run
from tests.certify.runs import check as check_run
from tests.conftest import CONFIGS
from tests.joints import cone, every_cone, with_cones

KEY = "joint_angle_deg"
LIGHT = {"nodes": 50, "coefficients": 22, "check_points": 2_000, "max_meshes": 1}
SAMPLES = np.linspace(0.0, 1.0, 2_001)


def largest_deg(path: Path, one: JointCone) -> float:
    """Sample the largest angle of a joint along a path."""
    return float(joint_angles_deg(one, sample_path(path, SAMPLES)).max())


def within(path: Path, one: JointCone, room_deg: float) -> JointCone:
    """Make a cone so wide that a path leaves room."""
    return replace(one, half_angle_deg=largest_deg(path, one) + room_deg)


def _proven(certificate: Certificate) -> np.ndarray:
    assert certificate.bounds is not None
    return certificate.bounds.ranges[KEY].values[:, 1]


def evidence_of(config: Config, machine: Machine, path: Path, certificate: Certificate) -> Evidence:
    """Evaluate the boxes of a path again."""
    (segment,) = evaluate_chain(machine, path, certificate.chain)
    cosines = joint_cosines(machine, segment.boxes, segment.displacement(machine))
    return Evidence(config, machine, upper_bounds(angles_above_deg(cosines.min(axis=1))))


@pytest.fixture(scope="module")
def conical(machine: Machine, line: Path) -> Machine:
    """Give all twelve joints cones that the short path keeps."""
    return with_cones(machine, *(within(line, one, 0.2) for one in every_cone(90.0)))


@pytest.fixture(scope="module")
def held(conical: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Prove the short path with these cones."""
    return prove(conical, line)


@pytest.fixture(scope="module")
def evidence(agder_config: Config, conical: Machine, line: Path, held: Certificate) -> Evidence:
    """Evaluate the boxes of the short path again."""
    return evidence_of(agder_config, conical, line, held)


def test_bounds_are_between_samples_and_limits(held: Certificate, conical: Machine, line: Path) -> None:
    """At all twelve joints, telescopes' included; the check finds no more than is stated, and no less than is true."""
    assert held.verdict == "certified"
    largest = np.array([largest_deg(line, one) for one in conical.joint_cones])
    allowed = np.array([one.half_angle_deg for one in conical.joint_cones])
    assert (largest <= _proven(held)).all()
    assert (_proven(held) <= allowed).all()


def test_what_is_stated_is_verified(held: Certificate, evidence: Evidence, conical: Machine, line: Path) -> None:
    """By other arithmetic, whose bounds are true and no wider; bounds that are too small or too large are not."""
    assert held.bounds is not None
    (claim,) = check(evidence, held.bounds)
    assert claim.verified
    assert (evidence.largest >= [largest_deg(line, one) for one in conical.joint_cones]).all()
    stated = held.bounds.ranges[KEY]
    wrong = []
    for change in (-0.05, 0.5):
        for joint in (0, 5, 9):
            values = stated.values.copy()
            values[joint, 1] += change
            wrong.append(replace(stated, values=values))
    wrong.append(replace(stated, subjects=stated.subjects[::-1]))
    wrong.append(replace(stated, subjects=stated.subjects[:-1], values=stated.values[:-1]))
    for ranges in wrong:
        (claim,) = check(evidence, replace(held.bounds, ranges={**held.bounds.ranges, KEY: ranges}))
        assert not claim.verified
    without = replace(held.bounds, ranges={key: found for key, found in held.bounds.ranges.items() if key != KEY})
    free = replace(evidence, machine=replace(conical, joint_cones=()), found=np.empty((0, 2)))
    for which, bounds, verified in ((evidence, without, False), (free, held.bounds, False), (free, without, True)):
        (claim,) = check(which, bounds)
        assert claim.verified == verified


def test_a_cone_a_little_too_narrow_is_not_certified(
    machine: Machine, line: Path, prove: Callable[..., Certificate]
) -> None:
    """A little wider than the path needs is enough, since boxes are halved until bounds are sharp."""
    for link, end in (("2b", "platform"), ("3a", "cart")):
        one = cone(link, end, (0.3, -0.5, 0.8), 90.0)
        for room_deg, verdict in ((-1e-3, "not certified"), (2e-3, "certified")):
            certificate = prove(with_cones(machine, within(line, one, room_deg)), line, least_width=1e-3)
            assert certificate.verdict == verdict
            if certificate.failure is not None:
                assert f"{end} joint of link {link} is not proven to stay within" in certificate.failure.reason.text


def test_a_joint_that_leaves_its_cone_briefly_is_found(
    agder_config: Config, machine: Machine, prove: Callable[..., Certificate]
) -> None:
    """By a thousandth of a degree, over a hundredth of the path, in its middle alone."""
    s = np.linspace(0.0, 1.0, 41)
    away = np.array([0.0, 0.02, -0.01, 0.03, 0.02])
    path = pose_path(machine, START + np.outer(4.0 * s * (1.0 - s), away), 0)
    one = cone("3b", "platform", (0.0, 0.3, -0.9), 90.0)
    angles = joint_angles_deg(one, sample_path(path, SAMPLES))
    if angles.argmax() in (0, len(angles) - 1):
        one = replace(one, axis=-one.axis)
        angles = joint_angles_deg(one, sample_path(path, SAMPLES))
    assert 900 < angles.argmax() < 1_100
    narrow = with_cones(machine, replace(one, half_angle_deg=float(angles.max()) - 1e-3))
    assert np.count_nonzero(angles > narrow.joint_cones[0].half_angle_deg) < 100
    certificate = prove(narrow, path, least_width=1e-4)
    assert certificate.failure is not None
    assert abs(certificate.failure.s - 0.5) < 0.05
    assert "platform joint of link 3b" in certificate.failure.reason.text
    wider = prove(with_cones(machine, replace(one, half_angle_deg=float(angles.max()) + 0.5)), path)
    assert wider.verdict == "certified"
    assert wider.bounds is not None
    (claim,) = check(evidence_of(agder_config, narrow, path, wider), wider.bounds)
    assert not claim.verified


@given(st.lists(st.floats(-1.0, 1.0) | st.floats(1.0 - 1e-9, 1.0), min_size=1, max_size=5))
@settings(max_examples=50)
def test_angles_of_cosines_are_bounded_from_above(cosines: list[float]) -> None:
    """Tightly, but next to 0 and 180 degrees, where a cosine says little of its angle."""
    found = angles_above_deg(np.array(cosines))
    for angle, cosine in zip(found.tolist(), cosines, strict=True):
        exact = arb(cosine).acos() * 180 / arb.pi()
        assert arb(angle) >= exact
        slack = 1e-10 / max(np.sqrt(1.0 - cosine**2), 1e-6)
        assert angle <= float(exact.mid()) + slack or cosine < -1.0 + 1e-6


FORGERIES: dict[str, Callable[[Data], object]] = {
    "less": lambda data: data["bounds"][KEY].update({"platform joint of link 2a": 1.0}),
    "more": lambda data: data["bounds"][KEY].update({"platform joint of link 2a": 179.0}),
    "missing": lambda data: data["bounds"].pop(KEY),
    "null": lambda data: data["bounds"].update({KEY: None}),
    "one missing": lambda data: data["bounds"][KEY].pop("cart joint of link 3b"),
    "another": lambda data: data["bounds"][KEY].update({"cart joint of link 1": 10.0}),
    "no number": lambda data: data["bounds"][KEY].update({"cart joint of link 3b": "1"}),
}


def test_forged_certificates_are_refused(
    own_task: Config, own_path: Path, vary: Callable, tmp_path: pathlib.Path
) -> None:
    """The genuine one is verified by the command; whatever is changed in it or in the cones beside it is refused."""
    cones = [cone("2a", "platform", (0.0, 0.99, -0.14), 90.0), cone("3b", "cart", (0.0, 0.41, 0.91), 90.0)]
    changes = {
        one.key: {"axis": one.axis.tolist(), "half_angle_deg": largest_deg(own_path, one) + 0.05} for one in cones
    }
    config = vary(own_task, changes)
    machine = build_machine(config.machine)
    path = replace(own_path, machine=machine)
    certificate = certify_path(config, machine, path)
    assert certificate.verdict == "certified"
    write_run(tmp_path / "true", config, path, certificate)
    genuine = check_run(tmp_path / "true")
    assert genuine.exit_code == 0, genuine.output
    assert "joints stay within their cones" in genuine.output
    for name, change in FORGERIES.items():
        folder = tmp_path / name
        write_run(folder, config, path, certificate)
        forge(folder, change)
        assert check_run(folder).exit_code != 0, name
    # The cones beside the certificate are what counts.
    narrower = vary(config, {f"{cones[0].key}.half_angle_deg": largest_deg(own_path, cones[0]) + 1e-6})
    write_run(tmp_path / "narrower", narrower, path, certificate)
    assert check_run(tmp_path / "narrower").exit_code == 1


@pytest.mark.slow
def test_a_machine_with_cones_is_planned_and_certified(vary: Callable) -> None:
    """Its route is another one, its path stays within the cones, a telescope's among them, and that is proven."""
    tiny = load_config(CONFIGS / "tiny.yaml")
    light = {f"refine.{key}": value for key, value in LIGHT.items()}
    cones = {
        "machine.links.l2a.platform_cone": {"axis": [0.0, 0.99, -0.14], "half_angle_deg": 115.0},
        "machine.links.l3b.cart_cone": {"axis": [0.0, 0.41, 0.91], "half_angle_deg": 52.0},
    }
    config = vary(tiny, light | cones)
    machine = build_machine(config.machine)
    free, route = (
        plan_route(one, build_machine(one.machine), build_regions(one, build_machine(one.machine)))
        for one in (tiny, config)
    )
    assert route.objective > 1.05 * free.objective
    refined = refine_path(config, machine, route)
    largest = np.array([largest_deg(refined.path, one) for one in machine.joint_cones])
    allowed = np.array([one.half_angle_deg for one in machine.joint_cones])
    assert (largest <= allowed).all()
    # The path comes as near to the edge of a cone as its nodes may.
    assert (allowed - largest).min() < 0.25
    certificate = certify_path(config, machine, refined.path)
    assert certificate.verdict == "certified"
    assert (largest <= _proven(certificate)).all()
    assert (_proven(certificate) <= allowed).all()
