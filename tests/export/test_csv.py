"""Tables as text and back: exact enough, readable by anyone."""

import csv
import io
import re
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.export import format_csv, read_csv, trajectory_columns
from pipeline.retime import TrajectorySamples


def _samples(rows: int, period_s: float = 0.001) -> TrajectorySamples:
    """Rows of an accelerated motion, every number different."""
    t = np.arange(rows, dtype=float) * period_s
    speed = np.linspace(0.01, 0.05, 5)
    return TrajectorySamples(
        period_s=period_s,
        t_s=t,
        q_m=1.0 + t[:, None] ** 2 * speed / 2.0,
        qd_mps=t[:, None] * speed,
        qdd_mps2=np.tile(-speed, (rows, 1)),
        pose=np.sin(t[:, None] + np.arange(6.0)),
        kappa=20.0 + np.cos(t),
    )


def test_a_trajectory_survives_the_way_through_text() -> None:
    """Header, LF line ends, as many rows as samples, every value within half a digit of the last decimal."""
    columns = trajectory_columns(_samples(50))
    text = format_csv(columns)
    assert text.splitlines()[0] == ",".join(columns)
    assert "\r" not in text
    assert text.endswith("\n")
    assert text.count("\n") == 51
    back = read_csv(text)
    assert list(back) == list(columns)
    for name, values in columns.items():
        assert np.abs(back[name] - values).max() <= 0.5001e-12


def test_rounding_does_not_show_in_differences_at_a_millisecond() -> None:
    """Differencing the written positions twice gives the acceleration to 1e-5 m/s^2."""
    back = read_csv(format_csv(trajectory_columns(_samples(200, period_s=0.001))))
    second = np.diff(back["q3_m"], 2) / 0.001**2
    assert second == pytest.approx(0.03, abs=1e-5)


@given(values=arrays(np.float64, st.integers(0, 20), elements=st.floats(-1e6, 1e6)), decimals=st.integers(0, 12))
def test_floats_have_fixed_decimals_and_no_negative_zero(values: np.ndarray, decimals: int) -> None:
    """Every number has that many decimals, is right to half of the last one, and zero has no sign."""
    lines = format_csv({"value": values}, decimals).splitlines()[1:]
    for line, value in zip(lines, values, strict=True):
        assert re.fullmatch(r"-?\d+" + (rf"\.\d{{{decimals}}}" if decimals else ""), line)
        assert not re.fullmatch(r"-0(\.0*)?", line)
        assert abs(float(line) - value) <= 0.5 * 10.0**-decimals * (1.0 + 1e-9) + 1e-9 * abs(value)


@pytest.mark.parametrize("value", [0.0, -0.0, 4e-13, -4e-13, -5e-13, 1e-300, -1e-300])
def test_what_rounds_to_zero_is_written_as_plain_zero(value: float) -> None:
    """Exact zeros stay exact, and no zero is negative."""
    assert format_csv({"value": [value]}) == "value\n0.000000000000\n"


def test_numbers_just_above_the_last_decimal_keep_their_sign() -> None:
    """Only zeros lose their sign."""
    assert format_csv({"value": [-6e-13, 6e-13]}) == "value\n-0.000000000001\n0.000000000001\n"


def test_whole_numbers_and_words_are_columns_too() -> None:
    """They come back with their type; words may hold commas and quotes."""
    columns = {
        "step": np.arange(3),
        "mode": np.array(["LLL", "LRL", 'say "R, R"']),
        "kappa": np.array([1.5, 2.0, 30.25]),
    }
    text = format_csv(columns, decimals=2)
    assert text == 'step,mode,kappa\n0,LLL,1.50\n1,LRL,2.00\n2,"say ""R, R""",30.25\n'
    back = read_csv(text)
    assert back["step"].dtype == np.int64
    assert back["kappa"].dtype == np.float64
    assert list(back["mode"]) == list(columns["mode"])
    assert list(csv.DictReader(io.StringIO(text)))[2]["mode"] == 'say "R, R"'


def test_a_table_may_have_no_rows() -> None:
    """The header alone is a table."""
    text = format_csv({"a": np.empty(0), "b": np.empty(0)})
    assert text == "a,b\n"
    assert {name: len(values) for name, values in read_csv(text).items()} == {"a": 0, "b": 0}


def test_nan_stays_nan() -> None:
    """A value that is missing is written as such."""
    assert np.isnan(read_csv(format_csv({"a": [np.nan, 1.0]}))["a"][0])


def test_integers_that_do_not_fit_are_read_as_floats() -> None:
    """Beyond 64 bits there are no integers."""
    np.testing.assert_array_equal(read_csv("a\n1\n" + "9" * 20 + "\n")["a"], [1.0, 1e20])


@pytest.mark.parametrize(
    ("columns", "error", "message"),
    [
        ({}, ValueError, "at least one column"),
        ({"a": [1.0], "b": [1.0, 2.0]}, ValueError, "a 1, b 2"),
        ({"a": np.ones((2, 2))}, TypeError, "column a must be one-dimensional"),
        ({"a": [True, False]}, TypeError, "column a must hold numbers or text"),
        ({"a": [1j]}, TypeError, "column a must hold numbers or text"),
    ],
)
def test_what_is_no_table_is_refused(columns: dict, error: type[Exception], message: str) -> None:
    """Mistakes of the caller are named with the column."""
    with pytest.raises(error, match=message):
        format_csv(columns)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1 must name every column once"),
        ("a,a\n1,2\n", "line 1 must name every column once"),
        ("a,b\n1,2\n3\n", "line 3 has 1 values for 2 columns"),
        ("a,b\n1,2,3\n", "line 2 has 3 values for 2 columns"),
        ("a,b\n1,\r2\n", "line 2 is no row of a table"),
        ("a" * 200_000, "line 1 is no row of a table"),
    ],
)
def test_what_is_no_table_cannot_be_read(text: str, message: str) -> None:
    """A file cut short or damaged is named by its line."""
    with pytest.raises(ValueError, match=message):
        read_csv(text)


def test_half_a_minute_at_a_millisecond_is_written_quickly() -> None:
    """30,001 rows of 23 columns take well under the couple of seconds one would notice."""
    columns = trajectory_columns(_samples(30_001))
    before = time.process_time()
    format_csv(columns)
    assert time.process_time() - before < 3.0
