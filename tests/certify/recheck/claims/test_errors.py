"""Claims of chains whose actuators are off: limits and reserves hold for all errors, or are refused."""

import numpy as np
import pytest

from pipeline.certify.recheck.claims import errors
from pipeline.certify.recheck.claims.distances import axis_distances, body_distances
from pipeline.certify.recheck.claims.evidence import lower_bounds, upper_bounds
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.machine.clearance import link_pairs
from tests.joints import cone, with_cones


def _evidence(
    machine: Machine, kappa: float = 50.0, signs: tuple[float, float] = (1.0, 1.0), least_m: float = 0.5
) -> errors.Evidence:
    distances = np.full(len(link_pairs(machine)), 0.5)
    distances[3] = least_m
    none = np.empty((0, 2))
    return np.array([[-np.inf, kappa], signs]), lower_bounds(distances), none, none, none


@pytest.mark.parametrize(
    ("kappa", "signs", "least_m", "kept"),
    [
        (100.0, (1.0, 1.0), 0.03, True),
        (100.1, (1.0, 1.0), 0.03, False),
        (np.nan, (1.0, 1.0), 0.03, False),
        (50.0, (-1.0, 1.0), 0.03, False),
        (50.0, (0.0, 0.0), 0.03, False),
        (50.0, (-1.0, -1.0), 0.0299, False),
        (50.0, (-1.0, -1.0), np.nan, False),
    ],
)
def test_every_limit_counts(
    agder_config: Config, machine: Machine, kappa: float, signs: tuple[float, float], least_m: float, kept: bool
) -> None:
    """Kappa up to its cap, det H of one sign, and every pair as far apart as is required."""
    claim = errors.limit_claim("chain", agder_config, machine, _evidence(machine, kappa, signs, least_m))
    assert claim.verified == kept


@pytest.mark.parametrize(("least_m", "kept"), [(0.005, True), (0.0049, False), (np.nan, False)])
def test_bodies_and_obstacles_count(
    bodies_config: Config, bodies_machine: Machine, vary, least_m: float, kept: bool
) -> None:
    """Any pair that is closer than machine.clearance.bodies_m refuses the claim."""
    box = {"centre_m": [1.0, 0.3, 0.5], "size_m": [0.1] * 3}
    config = vary(bodies_config, {"task.obstacles": [{"name": "box", "box": box}]})
    kappa, axes, _, joints, boxes = _evidence(bodies_machine)
    axes = lower_bounds(np.full(len(axis_distances.required_m(bodies_machine)), 0.5))
    asked = body_distances.required_m(config, bodies_machine)
    assert bodies_machine.bodies is not None
    assert len(asked) > len(bodies_machine.bodies.pairs)
    distances = np.full(len(asked), 0.5)
    distances[-1] = least_m
    found = kappa, axes, lower_bounds(distances), joints, boxes
    assert errors.limit_claim("chain", config, bodies_machine, found).verified == kept


@pytest.mark.parametrize(("angle_deg", "kept"), [(20.0, True), (20.1, False), (np.nan, False)])
def test_joints_count(agder_config: Config, machine: Machine, angle_deg: float, kept: bool) -> None:
    """Each joint turns no farther than its cone allows."""
    conical = with_cones(
        machine, cone("1", "cart", (1.0, 0.0, 0.0), 30.0), cone("2a", "platform", (0.0, 0.0, 1.0), 20.0)
    )
    *others, _, boxes = _evidence(machine)
    found = *others, upper_bounds(np.array([30.0, angle_deg])), boxes
    assert errors.limit_claim("chain", agder_config, conical, found).verified == kept


@pytest.mark.parametrize(("by", "kept"), [(0.0, True), (-1e-5, True), (-1.2e-5, False), (np.nan, False)])
def test_boxes_to_avoid_count(agder_config: Config, machine: Machine, vary, by: float, kept: bool) -> None:
    """The surface of any may be touched, but for what proofs round by."""
    config = vary(agder_config, {"task.avoid": [{"z_m": [0.0, 0.1]}, {"y_m": [2.0, 3.0]}]})
    found = *_evidence(machine)[:4], lower_bounds(np.array([0.5, by]))
    assert errors.limit_claim("chain", config, machine, found).verified == kept


def test_a_reserve_is_not_below_what_is_found() -> None:
    """Of either tilt; where none is stated, nothing is claimed."""
    found = np.array([0.5, 0.7])
    assert [claim.verified for claim in errors.reserve_claims("chain", found, (0.5, 0.7))] == [True]
    assert [claim.verified for claim in errors.reserve_claims("chain", found, (0.6, 0.69))] == [False]
    assert list(errors.reserve_claims("chain", found, None)) == []
