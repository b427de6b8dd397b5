"""What is true of the limits of every kind: margins, equality, order, and the directions they count in."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.limits import KINDS, Limit, admits, admitted, applying, move_limits, path_limits, pose_limits
from pipeline.limits.actuators import ActuatorRange
from pipeline.limits.avoid import AvoidedBox, Box
from pipeline.limits.axis_distance import AxisDistance
from pipeline.limits.gravity_stiffness import GravityStiffness
from pipeline.limits.holding_force import HoldingForce
from pipeline.limits.kappa import KappaCap
from pipeline.limits.link_link import for_poses as link_link_limits
from pipeline.limits.link_rail import for_poses as link_rail_limits
from pipeline.limits.tilt import TiltLimit
from pipeline.machine import Machine, build_machine
from pipeline.machine.samples import PoseSamples
from tests.joints import CONES

BOX = {"y_m": [0.1, 0.6], "z_m": [0.5, 1.0]}
PLATE = {
    "name": "plate",
    "attached_to": "platform",
    "box": {"centre_m": [0.0, 0.25, -0.05], "size_m": [0.2, 0.4, 0.02], "rounding_m": 0.005},
}
NOSE = {
    "name": "nose",
    "attached_to": "platform",
    "capsule": {"from_m": [0.0, 0.02, 0.0], "to_m": [0.0, 0.07, 0.0], "radius_m": 0.02},
}
BALL = {"name": "ball", "capsule": {"from_m": [1.0, 0.3, 0.7], "to_m": [1.0, 0.3, 0.7], "radius_m": 0.2}}


@pytest.fixture(scope="module")
def strict_config(agder_config: Config, vary) -> Config:
    """Ask for every limit there is, each of which some poses keep and others break."""
    return vary(
        agder_config,
        {
            "machine.clearance.link_link_m": 0.1,
            "machine.clearance.link_rail_m": 0.15,
            "machine.bodies": [PLATE, NOSE],
            "machine.dynamics.friction": {"carts_n": 60.0, "telescopes_n": 40.0},
            "machine.limits.holding_fraction": 0.3,
            "machine.limits.gravity_stiffness_npm": -800.0,
            **CONES,
            "task.tilt_max_deg": 15,
            "task.avoid": [BOX],
            "task.obstacles": [BALL],
            "route.kappa_max": 50,
        },
    )


@pytest.fixture(scope="module")
def strict(strict_config: Config) -> Machine:
    """Build the machine with every limit."""
    return build_machine(strict_config.machine)


@pytest.fixture(scope="module")
def draw_samples(draw_poses) -> Callable[..., PoseSamples]:
    """Give a function that draws poses that a machine reaches, whatever their limits."""

    def draw(machine: Machine, seed: int, count: int = 60) -> PoseSamples:
        drawn = draw_poses(machine, seed, count, 1e4)
        return PoseSamples(machine, drawn.pose, drawn.q_m)

    return draw


def every_limit(config: Config, machine: Machine) -> list[Limit]:
    """List the limits of all uses."""
    return [
        *pose_limits(machine, config.route.kappa_max),
        *move_limits(config, machine),
        *path_limits(config, machine),
    ]


@given(seed=st.integers(0, 2**32 - 1))
def test_margins_words_and_excess_agree(strict_config: Config, strict: Machine, draw_samples, seed: int):
    """A pose keeps a limit exactly if no margin is negative: then it is told nothing, and exceeds nothing."""
    samples = draw_samples(strict, seed, 20)
    # Moves and paths have margins of one direction besides, which a pose by itself does not break.
    still = np.zeros((len(samples), 5))
    for limit in every_limit(strict_config, strict):
        margins = limit.margins(samples)
        assert margins.shape == limit.excess(samples).shape
        np.testing.assert_array_equal(np.sign(margins.round(12)), -np.sign(limit.excess(samples).round(9)))
        kept = ((margins >= 0.0) | ~applying(limit, still)).all(axis=1)
        at_rest = applying(limit, still).all()
        for row in range(len(samples)):
            if at_rest:
                assert bool(limit.violations(samples.take(np.array([row])))) == (not kept[row])


@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_admitted_is_what_keeps_every_limit(strict_config: Config, strict: Machine, draw_samples, seed: int):
    """Whatever the order in which limits are checked, on poses that the others left."""
    samples, limits = draw_samples(strict, seed), pose_limits(strict, strict_config.route.kappa_max)
    expected = np.flatnonzero(np.all([admits(limit, samples) for limit in limits], axis=0))
    for order in (limits, limits[::-1]):
        rows, kept = admitted(order, samples)
        np.testing.assert_array_equal(rows, expected)
        np.testing.assert_array_equal(kept.pose, samples.pose[expected])
        np.testing.assert_array_equal(kept.kappa, samples.kappa[expected])


@given(seed=st.integers(0, 2**32 - 1))
def test_equality_is_admitted(machine: Machine, draw_samples, seed: int):
    """A pose exactly at a limit is usable; the nearest number on the other side is not."""
    samples = draw_samples(machine, seed, 20).take(np.array([0]))
    q, tilt = samples.q_m[0], np.abs(samples.pose[0, [3, 5]])
    exactly = [
        (lambda value: KappaCap(value), float(samples.kappa[0]), -1),
        (lambda value: TiltLimit(np.array([value, np.inf])), float(tilt[0]), -1),
        (lambda value: ActuatorRange(slice(0, 5), np.column_stack([q, [value, *q[1:]]])), float(q[0]), -1),
        (lambda value: ActuatorRange(slice(3, 5), np.column_stack([[value, q[4]], q[3:]])), float(q[3]), 1),
        (lambda value: AvoidedBox(Box(np.append(value, np.full(4, -9.0)), np.full(5, 9.0)), 0), samples.pose[0, 0], -1),
    ]
    for limits in (link_link_limits(machine, 1.0), link_rail_limits(replace(machine, link_rail_m=0.0), 1.0)):
        (distance,) = limits
        assert isinstance(distance, AxisDistance)
        exactly.append(
            (lambda value, limit=distance: replace(limit, least=value), float(distance.values(samples).min()), 1)
        )
    for build, value, towards_breaking in exactly:
        assert admits(build(value), samples)[0]
        assert not admits(build(value + towards_breaking * 1e-9 * max(abs(value), 1.0)), samples)[0]


@given(seed=st.integers(0, 2**32 - 1))
def test_limits_of_motion_are_no_milder_than_those_of_poses(strict_config, strict: Machine, draw_samples, seed: int):
    """What a pose breaks by itself it breaks on a move, too, so that regions never lack for the moves between them."""
    samples = draw_samples(strict, seed)
    for kind in KINDS:
        of_poses, of_moves = kind.for_poses(strict, 50.0), kind.for_moves(strict_config, strict)
        if of_poses and of_moves:
            broken = ~np.all([admits(limit, samples) for limit in of_poses], axis=0)
            assert not np.all([admits(limit, samples) for limit in of_moves], axis=0)[broken].any()


def test_cheap_limits_come_first(strict_config: Config, strict: Machine):
    """The order costs nothing but time."""
    costs = [limit.cost for limit in pose_limits(strict, strict_config.route.kappa_max)]
    assert costs == sorted(costs)
    assert len(set(costs)) > 3


def test_every_kind_limits_something(strict_config: Config, strict: Machine):
    """With everything asked for, no kind is silent, and every limit has its words."""
    for kind in KINDS:
        found = kind.for_path(strict_config, strict) + kind.for_moves(strict_config, strict)
        assert found
        for limit in found:
            assert all(vars(limit.wording)[key] for key in vars(limit.wording) if key != "raise_key")


def test_limits_that_are_not_asked_for_are_none(agder_config: Config, vary):
    """Rails unchecked, no masses, no boxes: nothing is checked at all."""
    changes = {
        "machine.dynamics": None,
        "machine.limits.carts.force_n": None,
        "machine.limits.telescopes.force_n": None,
        "machine.limits.link_force_n": None,
    }
    config = vary(agder_config, changes)
    machine = build_machine(config.machine)
    kinds = {type(limit) for limit in every_limit(config, machine)}
    assert not kinds & {HoldingForce, GravityStiffness, AvoidedBox}
    assert sum(isinstance(limit, AxisDistance) for limit in path_limits(config, machine)) == 1
