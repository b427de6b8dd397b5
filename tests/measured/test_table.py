"""Measurements as tables: both kinds are read, and anything else is refused."""

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import format_csv, read_csv
from pipeline.measured import measurement_columns, parse_measurement

T = np.array([0.0, 0.5, 1.0])
POSITIONS = np.arange(18.0).reshape(3, 2, 3)


def pose_columns() -> dict[str, np.ndarray]:
    """Give the columns of a pose as `trajectory.csv` has them, and one more."""
    names = ("t_s", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "kappa")
    return {name: T + index for index, name in enumerate(names)}


def test_reflectors_survive_the_way_through_text() -> None:
    """Written as CSV and read again, time and positions are the same."""
    read = parse_measurement(read_csv(format_csv(measurement_columns(T, POSITIONS))), 1.0)
    assert np.array_equal(read.t_s, T)
    assert read.reflectors_m is not None
    assert np.array_equal(read.reflectors_m, POSITIONS)
    assert read.controlled is None


def test_a_pose_is_read_from_the_columns_of_a_trajectory() -> None:
    """Of a trajectory's columns x, y, z, rx, rz are taken."""
    read = parse_measurement(pose_columns(), 1.0)
    assert read.reflectors_m is None
    assert read.controlled is not None
    assert np.array_equal(read.controlled, T[:, None] + [1.0, 2.0, 3.0, 4.0, 6.0])


def test_reflectors_go_before_a_pose() -> None:
    """Where both are there, reflectors are what was measured."""
    both = {**pose_columns(), **measurement_columns(T, POSITIONS)}
    assert parse_measurement(both, 1.0).controlled is None


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"t_s": None}, "not a measurement"),
        ({"x2_m": None}, "not a measurement"),
        ({"y1_m": np.array(["1", "2", "far"])}, "y1_m"),
        ({"z1_m": np.array([0.0, np.nan, 1.0])}, "z1_m"),
        ({"t_s": np.array([0.0, 0.5, 0.5])}, "must increase"),
        ({"t_s": np.array([0.5, 1.0, 1.5])}, "lasts 1 s"),
        ({"t_s": np.array([-0.5, 0.0, 0.5])}, "lasts 1 s"),
    ],
)
def test_what_is_no_measurement(change: dict[str, np.ndarray | None], expected: str) -> None:
    """Missing columns, words, gaps and times outside the motion are refused by name."""
    columns = {**measurement_columns(T, POSITIONS), **change}
    with pytest.raises(UsageError, match=expected):
        parse_measurement({name: values for name, values in columns.items() if values is not None}, 1.0)


def test_no_rows() -> None:
    """A header alone is not a measurement."""
    with pytest.raises(UsageError, match="no rows"):
        parse_measurement(read_csv("t_s,x1_m,y1_m,z1_m,x2_m,y2_m,z2_m\n"), 1.0)
