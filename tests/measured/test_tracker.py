"""Simulated measurements: what is asked for and nothing else is wrong with them."""

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine import Machine, inverse_kinematics
from pipeline.measured import Reflectors, SimulationSetting, reflector_positions, simulate_measurement
from pipeline.measured.perturbed import perturbed

POINTS = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])
QUIET = Reflectors(POINTS, 0.0)


@pytest.fixture(scope="module")
def motion(machine: Machine) -> tuple[FloatArray, FloatArray]:
    """Give actuators (n, 5) and poses (n, 6) on a line in working mode LLL."""
    controlled = np.linspace([1.02, 0.3, 0.9, 0.0, 0.0], [1.1, 0.5, 0.8, -0.2, 0.1], 300)
    solution = inverse_kinematics(machine, controlled, np.zeros(300, dtype=int))
    return solution.q_m, solution.pose


def test_a_perfect_machine_is_seen_as_commanded(machine: Machine, motion: tuple[FloatArray, FloatArray]) -> None:
    """Without noise and errors of geometry the reflectors are where the commanded poses have them."""
    seen = simulate_measurement(machine, *motion, QUIET, SimulationSetting(0.0))
    assert np.abs(seen - reflector_positions(POINTS, motion[1])).max() < 1e-11


def test_the_seed_decides(machine: Machine, motion: tuple[FloatArray, FloatArray]) -> None:
    """The same seed gives the same measurement, another one another."""
    reflectors = Reflectors(POINTS, 1e-4)
    first, again, other = (
        simulate_measurement(machine, *motion, reflectors, SimulationSetting(seed=seed)) for seed in (3, 3, 4)
    )
    assert np.array_equal(first, again)
    assert np.abs(first - other).min() > 0.0


def test_noise_comes_on_top(machine: Machine, motion: tuple[FloatArray, FloatArray]) -> None:
    """With the same seed the machine is wrong in the same way, whatever the noise; noise has its standard deviation."""
    setting = SimulationSetting(seed=5)
    quiet = simulate_measurement(machine, *motion, QUIET, setting)
    noise = simulate_measurement(machine, *motion, Reflectors(POINTS, 1e-4), setting) - quiet
    assert noise.std() == pytest.approx(1e-4, rel=5.0 / np.sqrt(2.0 * noise.size))


def test_errors_grow_with_those_of_the_geometry(machine: Machine, motion: tuple[FloatArray, FloatArray]) -> None:
    """Errors of the geometry are small: a tenth of them moves the reflectors by a tenth."""
    true = reflector_positions(POINTS, motion[1])
    large, small = (
        simulate_measurement(machine, *motion, QUIET, SimulationSetting(std_m, seed=2)) - true for std_m in (1e-4, 1e-5)
    )
    assert np.abs(large).max() > 1e-5
    assert small == pytest.approx(large / 10.0, abs=0.05 * np.abs(large).max() / 10.0)


def test_what_is_perturbed(machine: Machine) -> None:
    """Rails, joints and fixed lengths are all off, by the standard deviation; nothing else changes."""
    real, zeros_m = perturbed(machine, 1e-3, np.random.default_rng(0))
    names = ("rails_m", "platform_points_m", "cart_offsets_m", "lengths_m")
    off = np.concatenate([(getattr(real, name) - getattr(machine, name)).ravel() for name in names])
    off = np.concatenate([off[np.isfinite(off)], zeros_m])
    assert len(off) == 6 + 18 + 18 + 4 + 2
    assert np.abs(off).min() > 0.0
    assert off.std() == pytest.approx(1e-3, rel=0.3)
    others = [name for name, value in vars(machine).items() if isinstance(value, np.ndarray) and name not in names]
    assert "strokes_m" in others
    assert all(np.array_equal(getattr(real, name), getattr(machine, name)) for name in others)


@pytest.mark.parametrize(("std_m", "seed"), [(-1e-4, 0), (np.nan, 0), (np.inf, 0), (1e-4, -1), (1e-4, 0.5)])
def test_what_cannot_be_simulated(std_m: float, seed: int) -> None:
    """Errors and seeds that are none are refused."""
    with pytest.raises(UsageError):
        SimulationSetting(std_m, seed)


def test_a_motion_has_as_many_actuators_as_poses(machine: Machine, motion: tuple[FloatArray, FloatArray]) -> None:
    """Other shapes, and gaps, are refused by name."""
    q_m, pose = motion
    with pytest.raises(UsageError, match="expected as many rows of each"):
        simulate_measurement(machine, q_m, pose[1:], QUIET, SimulationSetting())
    with pytest.raises(UsageError, match="q_m: expected finite numbers"):
        simulate_measurement(machine, q_m * np.nan, pose, QUIET, SimulationSetting())
