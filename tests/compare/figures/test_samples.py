"""What figures read off samples: steps of the route and working modes."""

import numpy as np
import pytest

from pipeline.compare.figures.samples import corner_samples, working_modes
from pipeline.machine import MODES, Machine, inverse_kinematics
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route

from ..conftest import controlled_curve, make_route, make_samples


def test_corners_are_found_where_the_path_passes_them(route: Route, coarse: PathSamples) -> None:
    """The path was sampled ten times per step, so every tenth sample is a step."""
    np.testing.assert_array_equal(corner_samples(coarse, route), np.arange(0, 141, 10))


def test_places_that_are_passed_twice_are_found_in_turn(machine: Machine) -> None:
    """There and back the same way, steps on the way back are found on the way back."""
    there = np.linspace(0.0, 1.0, 31)
    steps = np.array([0.0, 0.4, 1.0, 0.4, 0.0])
    samples = make_samples(machine, controlled_curve(np.concatenate([there, there[-2::-1]])))
    np.testing.assert_array_equal(
        corner_samples(samples, make_route(machine, controlled_curve(steps))), [0, 12, 30, 48, 60]
    )


@pytest.mark.parametrize("mode", MODES)
def test_working_modes_are_those_of_the_inverse_kinematics(machine: Machine, mode: str) -> None:
    """Carts placed in a mode are seen in it, in the order of the arms."""
    controlled = np.array([[1.0, 0.3, 0.9, 0.0, 0.0], [1.0, 0.35, 0.85, 0.1, -0.1]])
    number = MODES.index(mode)
    solution = inverse_kinematics(machine, controlled, np.full(2, number))
    samples = _samples(solution.pose, solution.q_m)
    np.testing.assert_array_equal(working_modes(machine, samples), np.tile(MODE_SIGNS[number], (2, 1)))


def test_at_a_gate_the_mode_is_the_one_before(machine: Machine) -> None:
    """With the cart exactly beside its joint an arm is in neither mode, and keeps the one it comes from."""
    controlled = np.tile([1.0, 0.3, 0.9, 0.0, 0.0], (4, 1))
    modes = np.array([MODES.index("RLL"), MODES.index("RLL"), MODES.index("LLL"), MODES.index("LLL")])
    solution = inverse_kinematics(machine, controlled, modes, np.array([0, 1, 1, 0]))
    signs = working_modes(machine, _samples(solution.pose, solution.q_m))
    np.testing.assert_array_equal(signs[:, 0], [1.0, 1.0, 1.0, -1.0])
    np.testing.assert_array_equal(signs[:, 1:], -1.0)


def _samples(pose: np.ndarray, q_m: np.ndarray) -> PathSamples:
    nothing = np.zeros(len(pose))
    return PathSamples(nothing, pose, q_m, nothing, nothing, nothing, nothing, nothing)
