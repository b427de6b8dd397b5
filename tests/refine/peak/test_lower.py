"""Lowering the largest kappa on the mesh of a solution."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.mesh import even_mesh
from pipeline.refine.peak.lower import lower_peak, peak_problem
from pipeline.refine.problem import MeshSolution, Problem, build_problem, figures_of, fit_coarse
from pipeline.route import Route


def _problem(config: Config, machine: Machine, route: Route, **keys: object) -> Problem:
    refine = config.refine.model_copy(update=keys)
    return build_problem(config.model_copy(update={"refine": refine}), machine, route)


def _initial(problem: Problem) -> MeshSolution:
    return fit_coarse(problem, even_mesh(40, 16, np.zeros(0)))


def test_points_are_the_nodes_and_the_midpoints(light_config: Config, machine: Machine, route: Route) -> None:
    """Limits are those that nodes keep, with their margin where the start has it."""
    problem = _problem(light_config, machine, route)
    found = peak_problem(problem, _initial(problem))
    assert found is not None
    peak, iterate = found
    assert len(peak.points.s) == 2 * 40 - 1
    links, forces = peak.required.limits
    assert links.least.shape == links.limit.values(iterate.samples).shape
    assert forces.least.shape == forces.limit.values(iterate.samples).shape
    assert links.least.max() == pytest.approx(machine.link_link_m + light_config.refine.clearance_margin_m)


@pytest.mark.parametrize("objective", ["integral", "mixed", "maximum"])
def test_every_objective_lowers_the_largest_kappa(
    light_config: Config, machine: Machine, route: Route, objective: str
) -> None:
    """From the coarse path down, with the iterations counted."""
    problem = _problem(light_config, machine, route, objective=objective)
    initial = _initial(problem)
    lowered = lower_peak(problem, initial)
    assert figures_of(problem, lowered).kappa_max < figures_of(problem, initial).kappa_max
    assert lowered.iterations > 0
    np.testing.assert_allclose(lowered.path.q([0.0, 1.0]), initial.path.q([0.0, 1.0]), atol=1e-12)


def test_running_out_of_steps_is_a_failure_with_the_last_path(
    light_config: Config, machine: Machine, route: Route
) -> None:
    """What to change, and the path as arrays."""
    problem = _problem(light_config, machine, route, max_iterations=1)
    with pytest.raises(NoSolutionError, match="still falling after 1 steps") as caught:
        lower_peak(problem, _initial(problem))
    assert "refine.max_iterations" in caught.value.advice
    assert np.shape(caught.value.diagnosis["coefficients"]) == (16, 5)


def test_peaks_are_lowered_as_far_as_regions_show_to_be_possible(
    light_config: Config, machine: Machine, route: Route
) -> None:
    """A tenth above the least largest kappa of regions is the aim, where that is below 0.97 of the coarse path's."""
    found = []
    for least in (np.inf, 0.8 * route.kappa_max):
        problem = _problem(light_config, machine, replace(route, search=replace(route.search, least_kappa_max=least)))
        found.append(figures_of(problem, lower_peak(problem, _initial(problem))))
    assert found[0].kappa_max < 0.98 * problem.coarse_kappa_max
    assert found[1].kappa_max < 0.98 * found[0].kappa_max
    assert found[1].kappa_integral > found[0].kappa_integral
