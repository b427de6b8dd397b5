"""Bounds in a certificate's file: each key states its side, a key of a new limit needs nothing else."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from pipeline.artifacts.results.certificate.bounds import read_bounds, state_bounds
from pipeline.artifacts.results.certificate.shape import certificate_shape, explain
from pipeline.certify.bounds import Bounds, Ranges
from pipeline.limits import CertificateKey, Side, certificate_keys
from tests.certify.paths import bounds_of

FORCES = CertificateKey("force_n", Side.LARGEST, ("l1", "l2a"), optional=True)
KEYS = (*certificate_keys(), FORCES)


def whole_file(bounds: dict[str, Any]) -> dict[str, Any]:
    """Write a file around bounds."""
    chain = {
        "uncertainty": {"length_m": 0.0, "coordinate_m": 0.0},
        "s": [0.0, 1.0],
        "pose": [[[0.0] * 6] * 4],
        "radius": [[0.1] * 6],
        "joint_pose": [[0.0] * 6] * 2,
        "joint_radius": [[0.1] * 6] * 2,
    }
    return {
        "format": 3,
        "verdict": "certified",
        "refused_at_s": None,
        "refused_because": None,
        "boxes": 1,
        "path_sha256": "0" * 64,
        "premises_sha256": "0" * 64,
        "bounds": bounds,
        "tolerance_m": None,
        "coordinates_tolerance_m": None,
        "tolerances": {"link_length": None, "coordinates": None},
        "precision_bits": 64,
        "chains": [chain],
    }


def faults(bounds: dict[str, Any], keys: tuple[CertificateKey, ...]) -> list[str]:
    """Read a file and list what is wrong with it."""
    try:
        certificate_shape(keys).model_validate(whole_file(bounds))
    except ValidationError as error:
        return [explain(one) for one in error.errors(include_url=False)]
    return []


def with_forces() -> Bounds:
    """Add bounds of two forces."""
    bounds = bounds_of()
    forces = Ranges(("l1", "l2a"), np.array([[-np.inf, 100.0], [-np.inf, 200.0]]))
    return Bounds({**bounds.ranges, "force_n": forces}, bounds.kappa_s, bounds.start_miss, bounds.goal_miss)


def test_each_key_states_its_side() -> None:
    """A number, a sign, least distances, ranges, largest tilts, under the names of format 3."""
    assert state_bounds(bounds_of(), certificate_keys()) == {
        "kappa": 31.0,
        "det_sign": 1,
        "distance_m": {"links 1 and 2a": 0.1},
        "actuators_m": {name: [0.5, 1.5] for name in ("c1", "c2", "c3", "l2b", "l3b")},
        "tilt_deg": {"rx": 6.0, "rz": 3.0},
        "kappa_s": 0.5,
        "start_miss": 1e-11,
        "goal_miss": 2e-11,
    }


def test_what_is_stated_is_read() -> None:
    """Bit by bit, with the key of a new limit."""
    stated = state_bounds(with_forces(), KEYS)
    assert stated["force_n"] == {"l1": 100.0, "l2a": 200.0}
    shape = certificate_shape(KEYS).model_validate(whole_file(stated))
    read = read_bounds(shape.bounds.model_dump(exclude_unset=True), KEYS)
    assert read.ranges.keys() == with_forces().ranges.keys()
    for key, ranges in with_forces().ranges.items():
        assert read.ranges[key].subjects == ranges.subjects
        np.testing.assert_array_equal(read.ranges[key].values, ranges.values)
    assert (read.kappa_s, read.start_miss, read.goal_miss) == (0.5, 1e-11, 2e-11)


def test_an_optional_key_may_be_missing_and_no_other() -> None:
    """Certificates of before a limit was known are read."""
    stated = state_bounds(bounds_of(), certificate_keys())
    assert faults(stated, KEYS) == []
    shape = certificate_shape(KEYS).model_validate(whole_file(stated))
    assert "force_n" not in read_bounds(shape.bounds.model_dump(exclude_unset=True), KEYS).ranges
    for key in (key for key in certificate_keys() if not key.optional):
        missing = {name: value for name, value in stated.items() if name != key.name}
        assert faults(missing, KEYS) == [f"bounds.{key.name}: is missing"]


def test_a_key_without_a_limit_is_refused() -> None:
    """Whatever it states."""
    stated = state_bounds(with_forces(), KEYS)
    assert faults(stated, certificate_keys()) == ["bounds.force_n: is not a key of this format"]


@pytest.mark.parametrize(
    ("key", "value", "fault"),
    [
        ("kappa", -1.0, "bounds.kappa: is -1.0; expected a number of at least 0"),
        ("det_sign", 0, "bounds.det_sign: is 0; expected -1 or 1"),
        ("distance_m", {"links 1 and 2a": -0.1}, "is -0.1; expected a number of at least 0"),
        ("actuators_m", {"c1": [0.0, 1.0]}, "bounds.actuators_m.c2: is missing"),
        ("tilt_deg", {"rx": 1.0, "rz": 1.0, "ry": 1.0}, "bounds.tilt_deg.ry: is not a key of this format"),
        ("force_n", {"l1": 1.0}, "bounds.force_n.l2a: is missing"),
        ("force_n", None, "bounds.force_n: is null; expected a section"),
    ],
)
def test_values_have_the_shape_of_their_key(key: str, value: object, fault: str) -> None:
    """Names and numbers alike."""
    assert fault in "\n".join(faults({**state_bounds(with_forces(), KEYS), key: value}, KEYS))
