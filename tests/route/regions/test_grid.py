"""The grid: its axes and points."""

import numpy as np
import pytest

from pipeline.route.regions.grid import grid_axes, grid_points


def test_axes_hold_both_limits_and_multiples_of_the_tilt_steps(cross_config):
    """0.1 m and 10 degrees: 17 by 15 points, seven tilts each way, zero among them."""
    y, z, rx, rz = grid_axes(cross_config)
    np.testing.assert_allclose(y, np.linspace(-0.4, 1.2, 17))
    np.testing.assert_allclose(z, np.linspace(0.1, 1.5, 15))
    np.testing.assert_allclose(np.rad2deg(rx), [-30, -20, -10, 0, 10, 20, 30])
    np.testing.assert_array_equal(rx, rz)
    assert 0.0 in rx


@pytest.mark.parametrize(
    ("tilt", "step", "count"),
    [(30, 5, 13), (0.3, 0.1, 7), (29.9, 10, 5), (4, 5, 1), (0, 5, 1), (85, 0.7, 243)],
)
def test_a_tilt_limit_that_is_a_multiple_of_the_step_is_on_the_grid(quick_config, vary, tilt, step, count):
    """Rounding must not lose the outermost tilts, and nothing beyond them is added."""
    config = vary(quick_config, {"task.tilt_max_deg": tilt, "route.grid.rx_step_deg": step})
    rx = grid_axes(config)[2]
    assert len(rx) == count
    assert np.rad2deg(np.abs(rx)).max() <= tilt + 1e-12


def test_a_locked_axis_has_zero_alone(quick_config, vary):
    """The 4-DOF machines tilt about one axis, the 3-DOF machine about none."""
    assert [len(axis) for axis in grid_axes(vary(quick_config, {"task.locked_axes": ["rx"]}))[2:]] == [1, 7]
    assert [len(axis) for axis in grid_axes(vary(quick_config, {"task.locked_axes": ["rx", "rz"]}))[2:]] == [1, 1]


def test_an_axis_ends_before_a_limit_it_does_not_meet(quick_config, vary):
    """The last step is dropped when it would leave the range; a single point is a grid as well."""
    axes = {"y_m": {"min": 0.0, "max": 0.29, "step": 0.1}, "z_m": {"min": 0.5, "max": 0.5, "step": 0.1}}
    config = vary(quick_config, {f"route.grid.{name}": axis for name, axis in axes.items()})
    y, z = grid_axes(config)[:2]
    np.testing.assert_allclose(y, [0.0, 0.1, 0.2])
    np.testing.assert_allclose(z, [0.5])


def test_grid_points_are_all_combinations_once_with_x_zero(small_config):
    """The position along X is not a grid axis."""
    points = grid_points(small_config)
    assert len(points) == np.prod([len(axis) for axis in grid_axes(small_config)])
    assert len(np.unique(points, axis=0)) == len(points)
    assert not points[:, 0].any()
