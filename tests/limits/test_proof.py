"""What certificates state of limits: every kind names its keys, and its quantities stand under them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.limits import KINDS, CertificateKey, ProvenLimit, Side, certificate_keys, proven_limits
from pipeline.machine import Machine
from tests.joints import every_cone


@pytest.fixture(scope="module")
def limits(agder_config: Config, machine: Machine, vary) -> list[ProvenLimit]:
    """Take all proven limits, those of rails, joints and boxes to avoid too."""
    config = vary(agder_config, {"task.avoid": [{"x_m": [0.0, 0.1]}, {"rx_deg": [5.0, 6.0]}]})
    return proven_limits(config, replace(machine, link_rail_m=0.01, joint_cones=every_cone(170.0)))


def test_keys_are_those_of_the_format() -> None:
    """Each once, though two kinds of limit share one."""
    keys = certificate_keys()
    assert {key.name for key in keys} == {
        "kappa",
        "det_sign",
        "distance_m",
        "body_distance_m",
        "obstacle_distance_m",
        "actuators_m",
        "tilt_deg",
        "joint_angle_deg",
        "avoided_by",
        "holding_force_n",
        "gravity_stiffness_npm",
    }
    assert len({key.name for key in keys}) == len(keys)


def test_quantities_stand_under_the_keys_of_their_kind(agder_config: Config, machine: Machine) -> None:
    """And have the names that the key asks for."""
    for kind in KINDS:
        for limit in kind.for_path(agder_config, machine):
            if not isinstance(limit, ProvenLimit):
                assert kind.CERTIFICATE.keys == ()
                continue
            assert {quantity.key for quantity in limit.quantities} == set(kind.CERTIFICATE.keys)
            for key in kind.CERTIFICATE.keys:
                subjects = tuple(quantity.subject for quantity in limit.quantities if quantity.key == key)
                assert key.subjects is None or subjects == (key.subjects or (key.name,))


def allowed_bounds(limit: ProvenLimit) -> np.ndarray:
    """Give bounds that are exactly what is allowed."""

    def bounds(key: CertificateKey, allowed: tuple[float, float]) -> tuple[float, float]:
        return (1.0, 1.0) if key.side is Side.SIGN else allowed

    return np.array([bounds(quantity.key, quantity.allowed) for quantity in limit.quantities])


def test_bounds_at_a_limit_keep_it_and_bounds_beyond_do_not(limits: list[ProvenLimit]) -> None:
    """Equality is admitted; the quantity that is beyond is named."""
    for limit in limits:
        bounds = allowed_bounds(limit)
        assert limit.unproven(bounds) == ""
        for k, quantity in enumerate(limit.quantities):
            if quantity.key.side is not Side.SIGN:
                beyond = bounds.copy()
                beyond[k] += [-0.01, 0.01]
                assert quantity.subject in limit.unproven(beyond)


def test_bounds_that_are_no_numbers_keep_no_limit(limits: list[ProvenLimit]) -> None:
    """What cannot be computed is not proven."""
    for limit in limits:
        assert limit.unproven(np.full((len(limit.quantities), 2), np.nan))


def test_a_distance_that_is_short_by_micrometres_is_told_so(limits: list[ProvenLimit]) -> None:
    """Not as the distance that is asked for."""
    distances = [limit for limit in limits if {quantity.key.name for quantity in limit.quantities} == {"distance_m"}]
    assert distances
    for limit in distances:
        bounds = allowed_bounds(limit)
        bounds[0, 0] -= 5e-6
        assert limit.unproven(bounds).endswith(f"(at least {bounds[0, 0]:.6f} m)")
