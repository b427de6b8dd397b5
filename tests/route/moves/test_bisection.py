"""Lines followed by bisection, compared with marching along them in two thousand steps."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine import build_machine, condition_number, inverse_kinematics, min_distances, statics_matrix
from pipeline.machine.kinematics import closure_jacobian, follow, newton
from pipeline.machine.samples import PoseSamples
from pipeline.route.moves.bisection import sample_lines
from pipeline.route.moves.check import check_moves
from tests.conftest import WITHOUT_FORCE_LIMITS

SAMPLES = 2000
NARROW = 1e-5
"""Verdicts may differ where a limit is missed or kept by less: 1/kappa, metres, radians."""


def _random_machine(config, vary, random):
    """Move the joints, stretch the links; telescopes of any length, endless rails."""
    values = {f"machine.rails.{k}.travel_m": [-10.0, 10.0] for k in range(3)}
    for name, link in config.machine.links.model_dump().items():
        nudge = random.uniform(-0.03, 0.03, 3) * (random.random() < 0.6)
        values[f"machine.links.{name}.platform_point_m"] = list(np.add(link["platform_point_m"], nudge))
        if link.get("length_m"):
            values[f"machine.links.{name}.length_m"] = link["length_m"] * random.uniform(0.95, 1.05)
        if "stroke_m" in link:
            values[f"machine.links.{name}.stroke_m"] = [0.01, 9.0]
    return vary(config, values)


def _random_moves(machine, random, count):
    """Poses (n, 2, 6) and actuators (n, 2, 5) of moves as on some grid, in any working mode."""
    step, tilt = random.uniform(0.01, 0.16), np.deg2rad(random.choice([0.0, random.uniform(1.0, 16.0)]))
    first = random.uniform([0.0, -0.2, 0.3, -0.5, -0.5], [0.0, 1.0, 1.4, 0.5, 0.5], (20 * count, 5))
    if tilt == 0.0:
        first[:, 3:] = 0.0
    second = first + random.uniform(-1.0, 1.0, first.shape) * [0.0, step, step, tilt, tilt]
    modes = random.integers(0, 8, len(first))
    ends = [inverse_kinematics(machine, controlled, modes) for controlled in (first, second)]
    rows = np.flatnonzero(ends[0].reachable & ends[1].reachable)[:count]
    return np.stack([end.pose[rows] for end in ends], axis=1), np.stack([end.q_m[rows] for end in ends], axis=1)


def _marched(machine, pose, q):
    """Whether moves arrive with the sign of det H kept, (n,), and 1/kappa, least distance, tilt all along, (n, m)."""
    part = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None]
    line = q[:, :1] * (1.0 - part) + q[:, 1:] * part
    poses, misses = follow(machine, line, pose[:, 0])
    H = statics_matrix(machine, poses, line[..., :3])
    signs = np.sign(np.linalg.det(H))
    arrives = np.isfinite(misses).all(axis=1) & (np.abs(poses[:, -1] - pose[:, 1]).max(axis=1) < 1e-6)
    distance = min_distances(machine, poses.reshape(-1, 6), line.reshape(-1, 5)[:, :3])[0].reshape(signs.shape)
    tilt = np.abs(poses[..., [3, 5]]).max(axis=2)
    return arrives & (signs == signs[:, :1]).all(axis=1), 1.0 / condition_number(H), distance, tilt


def _limits(kappa_max=1e6, link_m=0.0, tilt_deg=85.0):
    return WITHOUT_FORCE_LIMITS | {
        "route.kappa_max": float(kappa_max),
        "machine.clearance.link_link_m": float(link_m),
        "task.tilt_max_deg": float(tilt_deg),
        "route.follow.tilt_overshoot_deg": 0.0,
    }


def test_same_verdict_as_two_thousand_samples(agder_config, vary):
    """One random machine, to be quick; the next test draws more of them."""
    _assert_same_verdicts(agder_config, vary, 0)


@pytest.mark.slow
@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_same_verdicts_for_any_machine_and_limits(agder_config, vary, seed):
    """For random machines, steps and limits nothing hides between the samples, and nothing good is refused."""
    _assert_same_verdicts(agder_config, vary, seed, moves=20)


def _assert_same_verdicts(agder_config, vary, seed, moves=10):
    """Put each limit in turn where it matters: at a typical extreme, and on either side of that of a single move."""
    random = np.random.default_rng(seed)
    config = _random_machine(agder_config, vary, random)
    machine = build_machine(config.machine)
    pose, q = _random_moves(machine, random, moves)
    arrives, nearness, distance, tilt = _marched(machine, pose, q)
    lax = vary(config, _limits())
    np.testing.assert_array_equal(check_moves(lax, build_machine(lax.machine), pose, q).good, arrives)
    pose, q = pose[arrives], q[arrives]
    extremes = {"nearness": nearness.min(axis=1), "link_m": distance.min(axis=1), "tilt_rad": -tilt.max(axis=1)}
    for name, least in extremes.items():
        kept = least[arrives]
        for limit in (np.quantile(kept, 0.4), kept[0] + 2 * NARROW, kept[0] - 2 * NARROW):
            if name == "tilt_rad" and limit > 0.0:
                continue
            changed = vary(config, _limits(**_as_key(name, limit)))
            checks = check_moves(changed, build_machine(changed.machine), pose, q)
            clear = np.abs(kept - limit) > NARROW
            np.testing.assert_array_equal(checks.good[clear], (kept >= limit)[clear])


def _as_key(name, limit):
    if name == "nearness":
        return {"kappa_max": 1.0 / max(limit, 1e-6)}
    return {"link_m": max(limit, 0.0)} if name == "link_m" else {"tilt_deg": np.rad2deg(-limit)}


def _no_margins(samples):
    return np.empty((len(samples), 0))


def test_the_rates_are_the_derivative_of_the_pose(machine):
    """Against central differences of forward kinematics, gates included: one actuator at a time."""
    controlled = np.array([[1.0, 0.3, 0.9, 0.1, -0.2], [1.0, 0.43, 0.5904, -0.02, 0.16]])
    solution = inverse_kinematics(machine, controlled, np.array([0, 7]), np.array([0, 1]))
    # The gate is one but for rounding.
    pose, _ = newton(machine, solution.q_m, solution.pose)
    seen = sample_lines(PoseSamples(machine, pose, solution.q_m), _no_margins)
    for actuator in range(5):
        shift = np.where(np.arange(5) == actuator, 1e-5, 0.0)
        ahead, behind = (follow(machine, (solution.q_m + way * shift)[:, None], pose)[0][:, 0] for way in (1.0, -1.0))
        np.testing.assert_allclose(seen.rates[:, :, actuator], (ahead - behind) / 2e-5, rtol=1e-4, atol=1e-4)


def test_a_pose_without_a_derivative_leaves_its_line_in_doubt(machine):
    """At a singular closure the rates are zero, not an error; the line is marched along then."""
    points = machine.platform_points_m.copy()
    points[:] = points[0]
    degenerate = replace(machine, platform_points_m=points)
    pose, q = np.array([[0.0, 0.3, 0.9, 0.0, 0.0, 0.0]]), np.zeros((1, 5))
    assert abs(np.linalg.det(closure_jacobian(degenerate, pose, q))[0]) < 1e-14
    seen = sample_lines(PoseSamples(degenerate, pose, q), _no_margins)
    assert not seen.rates.any()
