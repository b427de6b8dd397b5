"""Ellipsoids are of finite numbers, and of all parameters of a machine."""

from dataclasses import replace

import numpy as np
import pytest

from tests.certify.possible import some_ellipsoid


@pytest.mark.parametrize(
    "wrong",
    [
        {"factor": np.ones((55, 3))},
        {"factor": np.ones((56, 0))},
        {"factor": np.full((56, 3), np.nan)},
        {"sigma": 0.0},
        {"sigma": np.inf},
        {"scale": np.zeros(5)},
        {"zero_at_m": np.zeros(4)},
    ],
)
def test_what_is_no_ellipsoid_is_refused(wrong: dict[str, object]) -> None:
    """Shapes, numbers that are not finite, and no deviation at all."""
    with pytest.raises(ValueError, match="an ellipsoid has"):
        replace(some_ellipsoid(1e-4), **wrong)
