"""Figures of a path."""

import numpy as np
import pytest

from pipeline.refine import Path, Refinement, measure_path, sample_path


def test_length_and_integral_converge_with_order_two(refinement: Refinement, steps: np.ndarray) -> None:
    """The trapezoidal rule on twice the samples errs a quarter."""
    values = []
    for points in (201, 401, 801, 6401):
        figures = measure_path(sample_path(refinement.path, np.linspace(0.0, 1.0, points)), steps)
        values.append((figures.length, figures.kappa_integral))
    errors = np.abs(np.array(values[:-1]) - values[-1])
    orders = np.log2(errors[:-1] / errors[1:])
    assert (orders > 1.7).all(), orders


def test_the_largest_kappa_is_found_where_it_is(coarse: Path, steps: np.ndarray) -> None:
    """Value and place belong together."""
    figures = measure_path(sample_path(coarse, np.linspace(0.0, 1.0, 500)), steps)
    there = sample_path(coarse, np.array([figures.kappa_max_s]))
    assert there.kappa[0] == pytest.approx(figures.kappa_max)


def test_figures_do_not_depend_on_x(coarse: Path, steps: np.ndarray) -> None:
    """Carried along X the path has the same kappa, clearance and tilt."""
    samples = sample_path(coarse, np.linspace(0.0, 1.0, 50))
    shift = 0.1
    spline = type(coarse.spline)(coarse.spline.t, coarse.spline.c + [shift, shift, shift, 0.0, 0.0], coarse.spline.k)
    pose = coarse.node_pose + [shift, 0.0, 0.0, 0.0, 0.0, 0.0]
    moved = sample_path(Path(coarse.machine, spline, coarse.node_s, pose), samples.s)
    np.testing.assert_allclose(moved.kappa, samples.kappa, rtol=1e-8)
    np.testing.assert_allclose(moved.link_distance_m, samples.link_distance_m, atol=1e-9)
