"""Working modes seen on poses, against those that the inverse kinematics was asked for."""

import numpy as np
import pytest

from pipeline.machine import MODES, InverseSolution, Machine, inverse_kinematics
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.machine.working_modes import mode_names, mode_sequence, reach_along_rails, working_modes


def _seen(machine: Machine, solution: InverseSolution) -> np.ndarray:
    return working_modes(reach_along_rails(machine, solution.pose, solution.q_m[:, :3]))


@pytest.mark.parametrize("mode", MODES)
def test_they_are_those_of_the_inverse_kinematics(machine: Machine, mode: str) -> None:
    """Carts placed in a mode are seen in it, in the order of the arms."""
    controlled = np.array([[1.0, 0.3, 0.9, 0.0, 0.0], [1.0, 0.35, 0.85, 0.1, -0.1]])
    number = MODES.index(mode)
    modes = _seen(machine, inverse_kinematics(machine, controlled, np.full(2, number)))
    np.testing.assert_array_equal(modes, np.tile(MODE_SIGNS[number], (2, 1)))
    assert mode_names(modes) == [mode, mode]


def test_at_a_gate_the_mode_is_the_one_before(machine: Machine) -> None:
    """With the cart exactly beside its joint an arm is in neither mode, and keeps the one it comes from."""
    controlled = np.tile([1.0, 0.3, 0.9, 0.0, 0.0], (4, 1))
    modes = np.array([MODES.index("RLL"), MODES.index("RLL"), MODES.index("LLL"), MODES.index("LLL")])
    signs = _seen(machine, inverse_kinematics(machine, controlled, modes, np.array([0, 1, 1, 0])))
    np.testing.assert_array_equal(signs[:, 0], [1.0, 1.0, 1.0, -1.0])
    np.testing.assert_array_equal(signs[:, 1:], -1.0)
    assert mode_sequence(signs) == ["RLL", "LLL"]


def test_a_motion_that_begins_at_a_gate_is_in_the_mode_it_goes_to() -> None:
    """What rounding makes of the first reach does not count."""
    reach = np.array([[-1e-12, 0.1, -0.1], [0.2, 0.1, -0.1], [0.0, 0.1, -0.1]])
    assert mode_sequence(working_modes(reach)) == ["RRL"]
