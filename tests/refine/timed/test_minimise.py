"""Path and time law of quick.yaml, on a coarse mesh."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify import certify_path
from pipeline.config import Config, PoseConfig
from pipeline.config.task import VisitConfig
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine, inverse_kinematics
from pipeline.machine.pose import CONTROLLED
from pipeline.refine import Refinement, measure_path, sample_path
from pipeline.refine.problem import Problem, build_problem
from pipeline.refine.timed.hull import hull_fractions, rate_limits
from pipeline.refine.timed.minimise import minimise_time
from pipeline.refine.timed.motion import first_motion, halved, on_mesh
from pipeline.retime import retime_path
from pipeline.route import Route


@pytest.fixture(scope="module")
def config(light_config: Config) -> Config:
    """Ask for the least duration, below a cap on kappa."""
    refine = light_config.refine.model_copy(update={"objective": "time", "kappa_max": 35.0})
    return light_config.model_copy(update={"refine": refine})


@pytest.fixture(scope="module")
def problem(config: Config, machine: Machine, route: Route) -> Problem:
    """Build the problem."""
    return build_problem(config, machine, route)


@pytest.fixture(scope="module")
def timed(problem: Problem, refinement: Refinement) -> Refinement:
    """Find path and time law from the refined path."""
    return minimise_time(problem, refinement)


def test_every_limit_holds_at_100_000_instants(problem: Problem, timed: Refinement) -> None:
    """Velocity, acceleration and jerk by the hull; kappa, clearance and working modes by nodes and checks."""
    path, tau = timed.path, np.linspace(0.0, 1.0, 100_001)
    assert path.motion_s is not None
    for limit in rate_limits(path.machine):
        used = np.abs(path.q(tau, limit.order)).max(axis=0) / path.motion_s**limit.order / limit.largest
        assert used.max() <= 1.0 + 1e-12
    samples = sample_path(path, tau)
    figures = measure_path(samples, problem.steps)
    assert figures.kappa_max < 35.0
    assert figures.det_sign_constant
    assert figures.mode_changes == 3
    assert figures.measures["min_link_distance_m"] >= path.machine.link_link_m


def test_it_begins_and_ends_at_rest_without_acceleration(timed: Refinement) -> None:
    """Velocity and acceleration are zero at start and goal, which are those of the route."""
    for order in (1, 2):
        assert np.abs(timed.path.q(np.array([0.0, 1.0]), order)).max() < 1e-9
    np.testing.assert_allclose(timed.path.q(np.array([0.0, 1.0])), timed.coarse.q(np.array([0.0, 1.0])), atol=1e-9)


def test_the_motion_itself_is_certified(config: Config, machine: Machine, timed: Refinement) -> None:
    """The certificate holds for q(tau), with the cap on kappa."""
    certify_path(config, machine, timed.path)


def test_a_motion_that_does_not_converge_is_refused_with_its_arrays(problem: Problem, refinement: Refinement) -> None:
    """After too few iterations the last motion, and its duration, are in the diagnosis."""
    options = problem.config.refine.model_copy(update={"max_iterations": 1})
    hurried = replace(problem, config=problem.config.model_copy(update={"refine": options}))
    with pytest.raises(NoSolutionError, match="IPOPT ended") as raised:
        minimise_time(hurried, refinement)
    assert raised.value.diagnosis["motion_s"] > 0.0


def test_a_finer_mesh_has_the_same_motion(problem: Problem, refinement: Refinement) -> None:
    """Halving every knot span changes neither q(tau) nor the duration; nodes stay four to a coefficient."""
    motion = first_motion(problem, refinement.path, 40)
    finer = on_mesh(motion, halved(motion.mesh))
    tau = np.linspace(0.0, 1.0, 301)
    np.testing.assert_allclose(finer.path.q(tau), motion.path.q(tau), atol=1e-12)
    assert finer.motion_s == motion.motion_s
    assert finer.mesh.coefficients == 75
    assert len(finer.mesh.s) == 321
    assert (np.diff(motion.coarse.node_s) >= 0.0).all()


def test_another_time_law_of_the_same_path_is_hardly_faster(config: Config, timed: Refinement) -> None:
    """Stage three, free to choose s(t) under limited jerk, finds no more than one per cent."""
    retimed = retime_path(config, timed.path).timing
    assert retimed is not None
    assert timed.path.motion_s is not None
    assert 0.99 * timed.path.motion_s < retimed.motion_s <= timed.path.motion_s * (1.0 + 1e-9)


def test_without_jerk_limits_the_motion_is_faster(problem: Problem, refinement: Refinement, timed: Refinement) -> None:
    """With `retime.jerk` off only velocity and acceleration are limited, and stage three keeps the time law."""
    retime = problem.config.retime.model_copy(update={"jerk": False})
    config = problem.config.model_copy(update={"retime": retime})
    path = minimise_time(replace(problem, config=config), refinement).path
    assert path.machine is problem.machine
    fractions = {name: share.max() for name, share in hull_fractions(path.machine, path.spline, path.motion_s).items()}
    assert fractions["jerk"] > 1.05
    assert max(fractions["velocity"], fractions["acceleration"]) <= 1.0 + 1e-9
    assert path.motion_s < timed.path.motion_s
    trajectory = retime_path(config, path)
    assert trajectory.jerk_jumps
    assert trajectory.timing.motion_s == pytest.approx(path.motion_s, rel=1e-3)


def test_a_pose_to_visit_is_met_at_a_time_of_its_own(problem: Problem, refinement: Refinement) -> None:
    """A pose one centimetre off the refined path is on the motion, which passes it without a node there."""
    step, route = len(problem.route) // 2, problem.route
    near = refinement.path.pose(refinement.coarse.node_s[100 * step])[CONTROLLED]
    # This way: the other one is out of reach for the arm that changes its mode there.
    near[1] -= 0.01
    found = inverse_kinematics(problem.machine, near[None], route.modes[[step]])
    assert found.reachable.all()
    pose, visits, poses, q_m = found.pose[0], np.zeros_like(route.visits), route.pose.copy(), route.q_m.copy()
    poses[step], q_m[step], visits[step] = pose, found.q_m[0], 1
    x, y, z, rx, _, rz = pose.tolist()
    given = PoseConfig(x_m=x, y_m=y, z_m=z, rx_deg=np.rad2deg(rx), rz_deg=np.rad2deg(rz), mode="LLL")
    task = problem.config.task.model_copy(update={"visit": (VisitConfig(pose=given),)})
    asked = replace(
        problem,
        config=problem.config.model_copy(
            update={"task": task, "refine": problem.config.refine.model_copy(update={"corridor_cells": 1.0})}
        ),
        route=replace(route, pose=poses, q_m=q_m, visits=visits),
    )
    path = minimise_time(asked, refinement).path
    tau = np.linspace(0.0, 1.0, 20_001)
    far = np.abs(path.pose(tau) - pose)[:, CONTROLLED].max(axis=1)
    assert far.min() < 1e-3
    around = np.linspace(tau[far.argmin() - 1], tau[far.argmin() + 1], 20_001)
    assert np.abs(path.pose(around) - pose)[:, CONTROLLED].max(axis=1).min() < 1e-7
