"""The metric of the route."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.route.metric import CONTROLLED, arc_length, step_sizes


def test_step_sizes_are_the_grid_steps_and_the_travel_per_step_in_si_units(quick_config, vary):
    """x, y, z in metres come first, then rx and rz in radians."""
    config = vary(
        quick_config,
        {
            "route.x_step_m": 0.11,
            "route.grid.y_m.step": 0.2,
            "route.grid.z_m.step": 0.3,
            "route.grid.rx_step_deg": 18,
            "route.grid.rz_step_deg": 9,
        },
    )
    np.testing.assert_allclose(step_sizes(config.route), [0.11, 0.2, 0.3, np.pi / 10, np.pi / 20])


def test_arc_length_of_one_pose_is_zero():
    """A path that goes nowhere has no length."""
    assert arc_length(np.ones((1, 6)), np.ones(5)).tolist() == [0.0]


def test_a_full_step_of_one_coordinate_is_one_long():
    """That is what makes the integral of kappa compare with the sum (5)."""
    steps = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    poses = np.zeros((6, 6))
    for row, coordinate in enumerate(CONTROLLED):
        poses[row + 1 :, coordinate] += steps[row]
    np.testing.assert_allclose(arc_length(poses, steps), np.arange(6))


def test_steps_in_several_coordinates_add_up_as_in_euclid():
    """A move of three steps along x and four along z is five long."""
    poses = np.zeros((2, 6))
    poses[1, [0, 2]] = 0.3, 0.8
    assert arc_length(poses, np.array([0.1, 1.0, 0.2, 1.0, 1.0]))[-1] == pytest.approx(5.0)


@given(arrays(float, (7, 6), elements=st.floats(-2.0, 2.0)), st.floats(0.1, 10.0))
def test_arc_length_ignores_ry_and_scales_with_the_steps(poses, scale):
    """The angle ry is dependent, and doubling all steps halves the length; it never shrinks along the way."""
    steps = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    length = arc_length(poses, steps)
    turned = poses.copy()
    turned[:, 4] += 1.0
    np.testing.assert_allclose(arc_length(turned, scale * steps), length / scale, atol=1e-12)
    assert (np.diff(length) >= 0.0).all()


@given(arrays(float, (2, 6), elements=st.floats(-2.0, 2.0)))
def test_points_between_do_not_change_the_length_of_a_straight_line(ends):
    """Dividing a line further leaves its length alone."""
    part = np.linspace(0.0, 1.0, 9)[:, None]
    fine = ends[0] + part * (ends[1] - ends[0])
    assert arc_length(fine, np.ones(5))[-1] == pytest.approx(arc_length(ends, np.ones(5))[-1], abs=1e-12)
