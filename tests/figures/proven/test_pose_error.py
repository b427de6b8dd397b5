"""The proven error of the tool with samples under it."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from pipeline.figures.proven.pose_error import pose_error_figure
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.pose_error import DriveAmplification, PoseError, SampledError

EDGES = np.array([0.0, 0.25, 0.5, 1.0])
GAINS = np.arange(15.0).reshape(3, 5)


def _figure(errors: Uncertainty) -> Figure:
    found = PoseError(
        errors, EDGES, np.array([1e-3, 2e-3, 1e-3]), np.array([3e-3, 1e-3, 2e-3]), DriveAmplification(GAINS, GAINS)
    )
    s = np.array([0.1, 0.3, 0.7])
    return pose_error_figure(found, SampledError(s, np.array([9e-4, 1.9e-3, 8e-4]), np.array([2e-3, 9e-4, 1e-3])))


def test_bounds_are_above_the_samples_in_their_units() -> None:
    """Stairs of millimetres and milliradians, a dot per sample, and a line per drive."""
    position, rotation, amplified = _figure(Uncertainty(actuator_m=(1e-4,) * 5)).axes
    for axes, bounds in ((position, [1.0, 2.0, 1.0]), (rotation, [3.0, 1.0, 2.0])):
        (stairs,) = [patch for patch in axes.patches if isinstance(patch, StepPatch)]
        np.testing.assert_allclose(stairs.get_data().values, bounds)
        np.testing.assert_array_equal(stairs.get_data().edges, EDGES)
        assert (axes.lines[0].get_ydata() < bounds).all()
    lines = [patch.get_data().values for patch in amplified.patches if isinstance(patch, StepPatch)]
    np.testing.assert_array_equal(lines, GAINS.T)


@pytest.mark.parametrize(
    ("errors", "title"),
    [
        (Uncertainty(actuator_m=(1e-4,) * 5), "drives ±0.1 mm"),
        (Uncertainty(1e-4, 2e-5), "lengths ±0.1 mm; coordinates ±0.02 mm"),
        (Uncertainty(actuator_m=(1e-4, 1e-4, 1e-4, 5e-5, 0.0)), "drives ±0.1, 0.1, 0.1, 0.05, 0 mm"),
        (
            Uncertainty(1e-4, 2e-5, (1e-4, 1e-4, 1e-4, 5e-5, 0.0)),
            "drives ±0.1, 0.1, 0.1, 0.05, 0 mm\nlengths ±0.1 mm; coordinates ±0.02 mm",
        ),
    ],
)
def test_it_says_what_is_off(errors: Uncertainty, title: str) -> None:
    """And by how much."""
    assert _figure(errors).axes[0].get_title(loc="left") == title
