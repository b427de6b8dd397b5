"""Other units and the other direction are recognised, and nothing else is taken for them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.measured.plausibility import require_direction, require_units
from pipeline.measured.rows import RowError

NAMES = ("x_m", "y_m", "rx_rad")
S = np.linspace(0.0, 1.0, 50)
EXPECTED = np.column_stack([1.0 + 0.3 * S, 0.4 - 0.8 * S, -0.3 * S])


@pytest.mark.parametrize(
    ("factors", "expected"),
    [
        ((1e3, 1e3, 1.0), r"x_m, y_m: values look like millimetres.\n.*divide those in millimetres by 1000"),
        ((1.0, 1e3, 1.0), r"^index 0: y_m: values look like millimetres"),
        ((100.0, 1.0, 1.0), "x_m: values look like centimetres"),
        ((1e6, 1.0, 1.0), "micrometres by 1000000"),
        ((1 / 0.0254, 1.0, 1.0), "inches by 39.37"),
        ((1.0, 1.0, 180.0 / np.pi), "rx_rad: values look like degrees"),
        ((1e3, 1.0, 1e3), "x_m: values look like millimetres; rx_rad: values look like milliradians"),
    ],
)
def test_other_units(factors: tuple[float, ...], expected: str) -> None:
    """The columns, the unit and the factor are named."""
    with pytest.raises(RowError, match=expected):
        require_units(NAMES, EXPECTED * factors, EXPECTED)


@given(off=st.tuples(*[st.floats(-0.3, 0.3)] * 3), gain=st.floats(0.5, 2.0))
def test_errors_are_not_units(off: tuple[float, ...], gain: float) -> None:
    """Offsets of decimetres and a wrong scale are errors to be shown, not units."""
    require_units(NAMES, gain * EXPECTED + off, EXPECTED)


def test_values_near_zero_say_nothing() -> None:
    """Where nothing but noise is commanded, there is no ratio."""
    require_units(NAMES, np.full((5, 3), 1e-3), np.full((5, 3), 1e-6))


def test_the_other_direction() -> None:
    """A motion from the end to the start is recognised, also by part of it; standing still, or a wrong end, is not."""
    with pytest.raises(RowError, match=r"(?s)the other way.*--back"):
        require_direction(EXPECTED[::-1], EXPECTED)
    require_direction(EXPECTED, EXPECTED)
    require_direction(EXPECTED[[0] * 50], EXPECTED[[0] * 50])
    require_direction(EXPECTED[[0] * 50], EXPECTED)
    require_direction(EXPECTED[:1], EXPECTED[:1])


def test_the_other_direction_of_a_motion_that_ends_where_it_starts() -> None:
    """Its course tells, also with noise; the same way out and home has no direction."""
    loop = np.column_stack([np.cos(2 * np.pi * S), np.sin(2 * np.pi * S), 0.1 * np.sin(4 * np.pi * S)])
    noise = 0.001 * np.random.default_rng(1).standard_normal(loop.shape)
    with pytest.raises(RowError, match=r"(?s)the other way.*--back"):
        require_direction(loop[::-1] + noise, loop)
    require_direction(loop + noise, loop)
    there_and_home = np.concatenate([EXPECTED, EXPECTED[::-1]])
    require_direction(there_and_home[::-1] + 1e-3, there_and_home)
