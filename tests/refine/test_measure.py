"""Figures of a path."""

import numpy as np
import pytest

from pipeline.limits import measures
from pipeline.refine import Path, Refinement, measure_path, sample_path
from pipeline.refine.measure import kappa_trapezoids, merge_samples


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
    """Shifted along X the path has the same kappa, clearance and tilt."""
    samples = sample_path(coarse, np.linspace(0.0, 1.0, 50))
    shift = 0.1
    spline = type(coarse.spline)(coarse.spline.t, coarse.spline.c + [shift, shift, shift, 0.0, 0.0], coarse.spline.k)
    pose = coarse.node_pose + [shift, 0.0, 0.0, 0.0, 0.0, 0.0]
    moved = sample_path(Path(coarse.machine, spline, coarse.node_s, pose), samples.s)
    np.testing.assert_allclose(moved.kappa, samples.kappa, rtol=1e-8)
    np.testing.assert_allclose(moved.link_distance_m, samples.link_distance_m, atol=1e-9)


def test_every_measure_of_the_limits_is_taken(coarse: Path, steps: np.ndarray) -> None:
    """Least distances and the largest tilt, by their keys."""
    samples = sample_path(coarse, np.linspace(0.0, 1.0, 100))
    found = measure_path(samples, steps).measures
    assert list(found) == [measure.key for measure in measures() if measure.applies(coarse.machine)]
    assert found["min_link_distance_m"] == samples.link_distances_m.min()
    assert found["max_tilt_deg"] == pytest.approx(np.rad2deg(np.abs(samples.pose[:, [3, 5]]).max()))


def test_lengths_in_actuator_space(coarse: Path, steps: np.ndarray) -> None:
    """A polygon is as long as its moves together; to its own start and back there is no straight line."""
    corners = coarse.spline.c
    there = measure_path(sample_path(coarse, np.union1d(coarse.spline.t, np.linspace(0.0, 1.0, 100))), steps)
    assert there.actuator_length_m == pytest.approx(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    assert there.actuator_distance_m == pytest.approx(np.linalg.norm(corners[-1] - corners[0]))
    assert there.length_ratio == pytest.approx(there.actuator_length_m / there.actuator_distance_m)
    s = np.linspace(0.0, 1.0, 100)
    back = measure_path(sample_path(coarse, np.concatenate([s, s[::-1]])), steps)
    assert back.length_ratio is None


def test_merged_samples_are_those_of_all_parameters(coarse: Path) -> None:
    """In the order of s; what was known of the first is known of all."""
    first, more = sample_path(coarse, np.linspace(0.0, 1.0, 11)), sample_path(coarse, np.array([0.33, 0.05]))
    assert first.kappa.shape == (11,)
    merged, expected = merge_samples(first, more), sample_path(coarse, np.sort([*first.s, *more.s]))
    for name in ("s", "pose", "q_m", "kappa", "reach_m"):
        np.testing.assert_allclose(getattr(merged, name), getattr(expected, name), atol=1e-9, rtol=1e-9)
    assert "kappa" in vars(merged)


def test_trapezoids_are_exact_for_a_linear_kappa() -> None:
    """Over unevenly spaced samples."""
    length = np.array([0.0, 0.1, 0.5, 2.0])
    np.testing.assert_allclose(kappa_trapezoids(3.0 + 2.0 * length, np.diff(length)).sum(), 6.0 + 4.0)
