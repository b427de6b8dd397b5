"""The sequence of working modes along a path, in any corridor."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import MODES, Machine
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.refine import Path, Refinement, measure_path, refine_path, sample_path
from pipeline.refine.check import find_violations
from pipeline.refine.coarse import corner_parameters
from pipeline.refine.corridor.sides import sides_at
from pipeline.route import Route
from pipeline.route.metric import step_sizes


def test_both_ends_have_the_modes_of_the_route(route: Route, coarse: Path) -> None:
    """All L at the start, all R at the goal."""
    sides = sides_at(route, coarse, np.array([0.0, 1.0]))
    np.testing.assert_array_equal(sides, MODE_SIGNS[route.modes[[0, -1]]])


def test_an_arm_is_free_around_its_gate_and_nowhere_else(route: Route, coarse: Path) -> None:
    """Each of the three arms changes once: L, free, R, with its gate in the free part."""
    s = np.linspace(0.0, 1.0, 2_001)
    sides = sides_at(route, coarse, s)
    for arm in range(3):
        values = sides[:, arm][np.append(True, np.diff(sides[:, arm]) != 0.0)]
        np.testing.assert_array_equal(values, [-1.0, 0.0, 1.0])
        gate = corner_parameters(coarse)[np.flatnonzero(route.gates == arm + 1)]
        assert (sides[np.searchsorted(s, gate), arm] == 0.0).any()


def test_the_coarse_path_is_within(route: Route, coarse: Path) -> None:
    """Carts are on the side that they have to be on, all along."""
    s = np.linspace(0.0, 1.0, 1_001)
    samples = sample_path(coarse, s)
    assert (sides_at(route, coarse, s) * samples.reach_m > -1e-9).all()


@pytest.mark.parametrize("corridor", ["cells", "free"])
def test_a_path_has_the_working_modes_of_its_route(
    light_config: Config, machine: Machine, route: Route, corridor: str
) -> None:
    """Carts change sides once each, in the order of the route: its budget of mode changes is kept."""
    refine = light_config.refine.model_copy(update={"corridor": corridor})
    result = refine_path(light_config.model_copy(update={"refine": refine}), machine, route)
    figures = measure_path(sample_path(result.path, np.linspace(0.0, 1.0, 4_001)), step_sizes(light_config.route))
    assert list(figures.modes) == [name for name, _ in itertools.groupby(route.mode_names)]
    assert figures.mode_changes == route.mode_changes == 3


def test_other_working_modes_are_a_violation(light_config: Config, route: Route, refinement: Refinement) -> None:
    """A path along a route whose first and third arm change in each other's place is reported to be in other modes."""
    swapped = [MODES.index(name[::-1]) for name in route.mode_names]
    gates = np.array([0, 3, 2, 1])[route.gates]
    other = replace(route, gates=gates, modes=np.array(swapped))
    found = [violation.what for violation in find_violations(light_config, other, refinement.path, refinement.coarse)]
    assert any("another working mode" in what for what in found)


def test_a_budget_of_changes_is_that_of_the_path_too(
    light_config: Config, route: Route, refinement: Refinement
) -> None:
    """Three changes are within a budget of three, and one too many for a budget of two."""
    for budget, reported in ((3, False), (2, True)):
        limited = light_config.task.budget.model_copy(update={"mode_changes": budget})
        config = light_config.model_copy(update={"task": light_config.task.model_copy(update={"budget": limited})})
        found = [violation.what for violation in find_violations(config, route, refinement.path, refinement.coarse)]
        assert any("task.budget.mode_changes" in what for what in found) == reported


def test_an_arm_that_changes_back_and_forth_has_to_do_so(
    light_config: Config, route: Route, refinement: Refinement
) -> None:
    """Between two changes of one arm its side is required, and a path without them is reported to leave modes out."""
    modes, gates = np.zeros_like(route.modes), np.zeros_like(route.gates)
    modes[4:8] = MODES.index("RLL")
    gates[[3, 8]] = 1
    back_and_forth = replace(route, modes=modes, gates=gates)
    s = np.linspace(0.0, 1.0, 4_001)
    sides = sides_at(back_and_forth, refinement.coarse, s)
    first, last = corner_parameters(refinement.coarse)[[3, 8]]
    middle = np.abs(s - (first + last) / 2.0) < 0.24 * (last - first)
    np.testing.assert_array_equal(sides[middle], np.tile([1.0, -1.0, -1.0], (middle.sum(), 1)))
    values = sides[:, 0][np.append(True, np.diff(sides[:, 0]) != 0.0)]
    np.testing.assert_array_equal(values, [-1.0, 0.0, 1.0, 0.0, -1.0])
    found = [
        violation.what
        for violation in find_violations(light_config, back_and_forth, refinement.path, refinement.coarse)
    ]
    assert any("leaves out" in what or "another working mode" in what for what in found)
