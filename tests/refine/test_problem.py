"""The problem of stage two, and solutions on a mesh."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.machine import Machine
from pipeline.machine.kinematics import closure_residual
from pipeline.refine import Path, Refinement
from pipeline.refine.mesh import adapted_mesh, even_mesh
from pipeline.refine.problem import MeshSolution, Problem, build_problem, figures_of, fit_coarse, transfer_to
from pipeline.route import Route
from pipeline.route.metric import arc_length

S = np.linspace(0.0, 1.0, 401)


@pytest.fixture(scope="module")
def problem(light_config: Config, machine: Machine, route: Route) -> Problem:
    """Build the problem of the route."""
    return build_problem(light_config, machine, route)


@pytest.fixture(scope="module")
def fitted(problem: Problem) -> MeshSolution:
    """Fit the coarse path on an even mesh."""
    return fit_coarse(problem, even_mesh(50, 22, np.zeros(0)))


def test_the_fit_is_near_the_coarse_path_and_meets_its_ends(fitted: MeshSolution, coarse: Path) -> None:
    """Within a few centimetres of actuator travel, poses closed at every node."""
    assert np.abs(fitted.path.q(S) - coarse.q(S)).max() < 0.05
    np.testing.assert_allclose(fitted.path.q([0.0, 1.0]), coarse.q([0.0, 1.0]), atol=1e-12)
    path = fitted.path
    assert np.abs(closure_residual(path.machine, path.node_pose, path.q(path.node_s))).max() < 1e-9


def test_a_transferred_path_is_the_same_curve(problem: Problem, fitted: MeshSolution) -> None:
    """With more knots and nodes, and the iterations so far."""
    finer = adapted_mesh(fitted.mesh, fitted.path, problem.steps)
    moved = transfer_to(fitted, finer)
    assert len(moved.path.spline.c) > len(fitted.path.spline.c)
    np.testing.assert_allclose(moved.path.q(S), fitted.path.q(S), atol=1e-12)
    np.testing.assert_allclose(moved.path.pose(S), fitted.path.pose(S), atol=1e-9)
    assert moved.iterations == fitted.iterations


def test_an_end_with_a_direction_is_left_along_it(light_config: Config, machine: Machine, route: Route) -> None:
    """The first leg of the control polygon points in the direction of the actuators."""
    refine = light_config.refine.model_copy(update={"start_direction": (0.0, 1.0, 0.0)})
    problem = build_problem(light_config.model_copy(update={"refine": refine}), machine, route)
    c = fit_coarse(problem, even_mesh(50, 22, np.zeros(0))).path.spline.c
    leg = (c[1] - c[0]) / np.linalg.norm(c[1] - c[0])
    np.testing.assert_allclose(leg, problem.directions[0], atol=1e-9)


def test_length_and_largest_kappa_are_those_of_the_coarse_path(problem: Problem, refinement: Refinement) -> None:
    """Lengths in the metric of the route; the refined path has no larger kappa."""
    assert problem.length == arc_length(refinement.coarse.node_pose, problem.steps)[-1]
    mesh = even_mesh(50, 22, np.zeros(0))
    refined = MeshSolution(mesh, refinement.path, 0.0, 0)
    assert figures_of(problem, refined).kappa_max <= problem.coarse_kappa_max


def test_a_cap_below_kappa_at_an_end_is_refused(light_config: Config, machine: Machine, route: Route) -> None:
    """Before anything is solved."""
    refine = light_config.refine.model_copy(update={"kappa_max": 22.0})
    with pytest.raises(ConfigError, match="start or the goal is 23"):
        build_problem(light_config.model_copy(update={"refine": refine}), machine, route)
