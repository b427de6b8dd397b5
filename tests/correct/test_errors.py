"""Errors of poses, reduced to figures."""

import numpy as np
import pytest

from pipeline.correct import pose_errors


def test_figures_are_those_of_the_distances() -> None:
    """Distances and tilts are lengths of their vectors; ry does not count, and angles wrap."""
    planned = np.zeros((3, 6))
    planned[2, 3] = np.pi - 0.001
    reached = planned.copy()
    reached[1] = [0.003, 0.004, 0.0, 0.0, 0.5, 0.002]
    reached[2, 3] = 0.002 - np.pi
    facts = pose_errors(np.array([0.0, 0.4, 1.0]), reached, planned).as_json()
    assert facts == pytest.approx(
        {
            "rms_m": 0.005 / np.sqrt(3.0),
            "largest_m": 0.005,
            "largest_s": 0.4,
            "rms_rad": np.sqrt((0.002**2 + 0.003**2) / 3.0),
            "largest_rad": 0.003,
            "largest_rad_s": 1.0,
        }
    )
