"""The least integral of kappa on a mesh."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits import node_limits
from pipeline.machine import Machine
from pipeline.refine.collocation.ipopt import IpoptOptions
from pipeline.refine.integral.minimise import guess_from, minimise_integral, program_data, solve_on_mesh
from pipeline.refine.mesh import even_mesh
from pipeline.refine.problem import FROBENIUS, MeshSolution, Problem, build_problem, figures_of, fit_coarse
from pipeline.route import Route


@pytest.fixture(scope="module")
def problem(light_config: Config, machine: Machine, route: Route) -> Problem:
    """Build the problem of the route."""
    return build_problem(light_config, machine, route)


@pytest.fixture(scope="module")
def initial(problem: Problem) -> MeshSolution:
    """Fit the coarse path."""
    return fit_coarse(problem, even_mesh(40, 16, np.zeros(0)))


def test_the_integral_falls_and_the_surrogate_knows_it(
    light_config: Config, machine: Machine, route: Route, steep_route: Route
) -> None:
    """Far below that of a zigzag's fit, and below that of a path that is near already; the smooth kappa is as true."""
    for along, least in ((route, 0.89), (steep_route, 0.82)):
        problem = build_problem(light_config, machine, along)
        initial = fit_coarse(problem, even_mesh(40, 16, np.zeros(0)))
        found = minimise_integral(problem, initial)
        before, after = figures_of(problem, initial).kappa_integral, figures_of(problem, found).kappa_integral
        assert after < least * before
        assert found.integral == pytest.approx(after, rel=0.005)
        assert found.mesh is initial.mesh


def test_the_program_gets_the_limits_of_nodes(problem: Problem, initial: MeshSolution) -> None:
    """Those that have rows; the guess is the initial path at its nodes."""
    data, guess = program_data(problem, initial, FROBENIUS, 1.0), guess_from(initial)
    kept = node_limits(problem.config, problem.machine)
    assert [limit.wording.name for limit in data.nodes.limits] == [limit.wording.name for limit in kept]
    np.testing.assert_array_equal(guess.nodes.pose, initial.path.node_pose)
    np.testing.assert_array_equal(guess.coefficients, initial.path.spline.c)


def test_too_few_iterations_name_what_is_violated(problem: Problem, initial: MeshSolution) -> None:
    """The failure has the worst groups of constraints in words, all of them and the last path in its diagnosis."""
    with pytest.raises(
        NoSolutionError, match=r"Maximum_Iterations_Exceeded after 1 iterations; most violated"
    ) as caught:
        solve_on_mesh(problem, initial, FROBENIUS, 1.0, IpoptOptions(1, 60.0))
    assert caught.value.diagnosis["status"] == "not converged"
    assert {"closure", "spline", "length"} <= set(caught.value.diagnosis["violations"])
    assert np.shape(caught.value.diagnosis["coefficients"]) == (16, 5)
