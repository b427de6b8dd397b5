"""The force to hold the machine: against inverse dynamics, by direction, and in the nonlinear program."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.limits import counting
from pipeline.limits.holding_force import HoldingForce, for_moves, for_path, for_poses
from pipeline.limits.interface.rows import Nodes
from pipeline.machine import Machine, build_machine
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions
from tests.machine.test_statics import mirrored


@pytest.fixture(scope="module")
def heavy_config(quick_config: Config, vary) -> Config:
    """Load the machine with 45 kg and friction."""
    return vary(
        quick_config,
        {
            "machine.dynamics.platform.mass_kg": 25.0,
            "machine.dynamics.load_kg": 20.0,
            "machine.dynamics.friction": {"carts_n": 80.0, "telescopes_n": 50.0},
        },
    )


@pytest.fixture(scope="module")
def heavy(heavy_config: Config) -> Machine:
    """Build the heavy machine."""
    return build_machine(heavy_config.machine)


def _samples(machine: Machine, draw_poses, seed: int) -> PoseSamples:
    drawn = draw_poses(machine, seed)
    return PoseSamples(machine, drawn.pose, drawn.q_m)


@pytest.fixture(scope="module", params=[1.0, 0.1], ids=["weak friction", "friction above the limit"])
def rubbing(heavy: Machine, request: pytest.FixtureRequest) -> Machine:
    """Take the heavy machine, and one whose friction is more than it may hold."""
    return replace(heavy, holding_fraction=request.param)


def _resting(samples: PoseSamples) -> tuple[np.ndarray, np.ndarray]:
    still, carts_still = np.zeros_like(samples.pose), np.zeros_like(samples.carts_m)
    machine = samples.machine
    assert machine.masses is not None
    found = inverse_dynamics(machine, machine.masses, samples.pose, samples.carts_m, still, still, carts_still)
    return found.drive_n, found.link_n


def _lopsided(machine: Machine, seed: int) -> Machine:
    """Draw limits that differ for push and pull, of every drive and of the links."""
    random = np.random.default_rng(seed)
    force, link = machine.force_n * random.uniform(0.3, 1.5, (2, 5)), random.uniform(300.0, 2_000.0, 2)
    return replace(machine, force_n=force, link_force_n=link)


@given(seed=st.integers(0, 2**32 - 1))
def test_a_pose_is_held_exactly_if_dynamics_at_rest_say_so(heavy: Machine, draw_poses, seed: int):
    """Push F - R <= fraction L, pull -F - R <= fraction L with its own L; links have no friction R."""
    heavy = _lopsided(heavy, seed)
    samples = _samples(heavy, draw_poses, seed)
    drive, link = _resting(samples)
    for fraction in (1.0, 0.4):
        (limit,) = for_poses(replace(heavy, holding_fraction=fraction), 100.0)
        held = (drive - heavy.masses.friction_n <= fraction * heavy.force_n[0]).all(axis=1)
        held &= (-drive - heavy.masses.friction_n <= fraction * heavy.force_n[1]).all(axis=1)
        held &= ((link <= fraction * heavy.link_force_n[0]) & (-link <= fraction * heavy.link_force_n[1])).all(axis=1)
        np.testing.assert_array_equal((limit.margins(samples) >= 0.0).all(axis=1), held)


@given(seed=st.integers(0, 2**32 - 1))
def test_push_and_pull_change_sides_in_a_mirror(heavy: Machine, draw_poses, seed: int):
    """Reflected in x = 0, carts push where they pulled; telescopes and links do as before."""
    machine = _lopsided(heavy, seed)
    samples = _samples(machine, draw_poses, seed)
    carts_swapped = np.column_stack([machine.force_n[::-1, :3], machine.force_n[:, 3:]])
    reflected = replace(mirrored(machine), force_n=carts_swapped)
    # R = Rx(rx) Rz(rz) Ry(ry): a reflection turns ry and rz the other way round.
    image = PoseSamples(reflected, samples.pose * [-1, 1, 1, 1, -1, -1], samples.q_m * [-1, -1, -1, 1, 1])
    (limit,), (other,) = for_poses(machine, 100.0), for_poses(reflected, 100.0)
    signs = np.append(np.full(3, -1.0), np.ones(8))
    np.testing.assert_allclose(image.holding_forces_n, signs * samples.holding_forces_n, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(other.shares(image), limit.shares(samples), rtol=1e-6, atol=1e-9)


def test_pull_and_push_are_told_apart(heavy: Machine):
    """A telescope in tension is told what it may pull, in compression what it may push."""
    masses = replace(heavy.masses, friction_n=np.zeros(5))
    force = np.array([[400.0, 400.0, 400.0, 90.0, 1e3], [400.0, 400.0, 400.0, 70.0, 1e3]])
    pose, q = np.array([[1.0, 0.3, 0.9, 0.0, 0.0, 0.0]]), np.ones((1, 5))
    for sign, words in ((1.0, "of push from l2b to hold the machine; at most 90 N"), (-1.0, "of pull from l2b")):
        H = np.eye(6)[None]
        H[0, 2, 2] = 0.1 * sign
        (limit,) = for_poses(replace(heavy, masses=masses, force_n=force, link_force_n=np.inf), 100.0)
        (message,) = limit.violations(PoseSamples(heavy, pose, q).with_known(H=H))
        assert words in message


@given(seed=st.integers(0, 2**32 - 1))
def test_a_path_has_to_overcome_friction_in_the_direction_it_goes(rubbing: Machine, heavy_config, draw_poses, seed):
    """The drive has F + R sign(velocity) to give, and holds against F - R at rest."""
    rubbing = _lopsided(rubbing, seed)
    samples = _samples(rubbing, draw_poses, seed)
    directions = np.random.default_rng(seed).integers(-1, 2, (len(samples), 5)).astype(float)
    drive, link = _resting(samples)
    (limit,) = for_path(heavy_config, rubbing)
    assert isinstance(limit, HoldingForce)
    push, pull = rubbing.holding_fraction * rubbing.force_n
    friction = rubbing.masses.friction_n
    # Only the force in the direction of motion has friction to overcome; at rest, and against it, friction helps.
    kept = (drive - np.where(directions > 0.0, -friction, friction) <= push).all(axis=1)
    kept &= (-drive - np.where(directions < 0.0, -friction, friction) <= pull).all(axis=1)
    push, pull = rubbing.holding_fraction * np.asarray(rubbing.link_force_n)
    kept &= ((link <= push) & (-link <= pull)).all(axis=1)
    counted = (limit.margins(samples) >= 0.0) | ~limit.applies(directions)
    np.testing.assert_array_equal(counted.all(axis=1), kept)


def test_moves_leave_the_directions_of_carts_open(heavy: Machine, heavy_config: Config):
    """X is free between regions: only strokes decide which way friction acts."""
    (limit,) = for_moves(heavy_config, heavy)
    assert isinstance(limit, HoldingForce)
    carts, telescopes = np.array([[1.0, 1.0, 1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0, 1.0, -1.0]])
    at_rest = limit.applies(np.zeros((1, 5)))
    np.testing.assert_array_equal(limit.applies(carts), at_rest)
    assert np.count_nonzero(limit.applies(telescopes)) == np.count_nonzero(at_rest) + 2


@given(seed=st.integers(0, 2**32 - 1))
def test_margins_agree_with_values_in_sign(rubbing: Machine, heavy_config: Config, draw_poses, seed: int):
    """Also where gravity pushes a drive in the direction it moves, against more friction than it could overcome."""
    samples = _samples(rubbing, draw_poses, seed)
    (limit,) = for_path(heavy_config, rubbing)
    assert isinstance(limit, HoldingForce)
    margins, values, excess = limit.margins(samples), limit.values(samples), limit.excess(samples)
    np.testing.assert_array_equal(margins >= 0.0, values >= 0.0)
    np.testing.assert_array_equal(values >= 0.0, excess <= 0.0)


def test_margins_go_to_minus_one_at_a_singularity(machine: Machine):
    """A singular H is no reason to fail: the margin is continuous there."""
    (limit,) = for_poses(machine, 100.0)
    pose = np.tile([1.0, 0.3, 0.9, 0.0, 0.0, 0.0], (3, 1))
    regular = np.tile(np.eye(6), (3, 1, 1))
    H = regular * np.array([1.0, 1e-9, 0.0])[:, None, None]
    samples = PoseSamples(machine, pose, np.ones((3, 5))).with_known(H=H)
    worst = limit.margins(samples).min(axis=1)
    assert worst[1] == pytest.approx(-1.0, abs=1e-3)
    assert worst[2] == -1.0


def test_what_is_not_limited_refuses_nothing(machine: Machine):
    """Bounds may be infinite for a drive without a limit."""
    (limit,) = for_poses(replace(machine, force_n=np.append(np.full(3, np.inf), [1e3, 1e3])), 100.0)
    assert isinstance(limit, HoldingForce)
    bounds = np.append(np.full(3, np.inf), np.full(8, 900.0))[:, None] * [-1.0, 1.0]
    assert limit.unproven(bounds) == ""
    for side, value in ((0, -1_001.0), (1, 1_001.0)):
        wrong = bounds.copy()
        wrong[3, side] = value
        assert limit.unproven(wrong).startswith("l2b is not proven to hold the machine (bound 1001 N)")


def test_regions_are_those_that_can_be_held(heavy_config: Config, heavy: Machine):
    """Regions without force limits, less those that break one."""
    free = replace(heavy, force_n=np.full(5, np.inf), link_force_n=np.inf)
    every, held = build_regions(heavy_config, free), build_regions(heavy_config, heavy)
    (limit,) = for_poses(heavy, 100.0)
    keeps = (limit.margins(every.samples(heavy)) >= 0.0).all(axis=1)
    assert 0 < np.count_nonzero(~keeps) < len(every) / 2
    np.testing.assert_array_equal(every.take(keeps).controlled, held.controlled)


@given(seed=st.integers(0, 2**32 - 1))
def test_rows_hold_exactly_where_the_values_do(heavy_config: Config, heavy: Machine, draw_poses, seed: int):
    """At the initial guess the forces close the equilibrium, and rows are kept where values keep their margin."""
    heavy = _lopsided(heavy, seed)
    samples = _samples(heavy, draw_poses, seed)
    samples = samples.take(slice(0, 12))
    directions = np.random.default_rng(seed).integers(-1, 2, (len(samples), 5)).astype(float)
    (limit,) = for_path(heavy_config, heavy)
    assert isinstance(limit, HoldingForce)
    pose, q = ca.MX.sym("pose", 6, len(samples)), ca.MX.sym("q", 5, len(samples))
    nodes = Nodes(pose, q, samples, directions, clearance_margin_m=0.0, reach_m=0.05)
    part = limit.program_part(nodes)
    inner = (limit.values(samples) - limit.node_margin(0.0) >= 0.0) | ~counting(limit, samples, directions)
    expected = bool(inner[1:-1].all())
    if not part.rows:
        assert expected
        return
    (unknown,) = part.unknowns
    kept = True
    for row in part.rows:
        evaluate = ca.Function("row", [pose, q, unknown.symbol], [row.expression])
        found = np.array(evaluate(samples.pose.T, samples.q_m.T, unknown.guess.T))
        if "equilibrium" in row.name:
            assert np.abs(found).max() < 1e-9
        else:
            kept &= bool((found >= row.low - 1e-12).all() and (found <= row.high + 1e-12).all())
    assert kept == expected


def test_the_words_name_drive_force_and_limit(heavy: Machine):
    """A pose that cannot be held is told with the force, the limit and what friction carries."""
    machine = replace(heavy, holding_fraction=0.5)
    pose, q = np.array([[1.0, 0.3, 0.9, 0.0, 0.0, 0.0]]), np.ones((1, 5))
    H = np.eye(6)[None]
    H[0, 2, 2] = 0.1
    (limit,) = for_poses(machine, 100.0)
    messages = limit.violations(PoseSamples(machine, pose, q).with_known(H=H))
    assert any(message.startswith("needs") and "from l2b to hold the machine" in message for message in messages)
    assert any(
        "550 N is allowed (0.5 of its force limit of 1000 N, and 50 N of dry friction)" in message
        for message in messages
    )
