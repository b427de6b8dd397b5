"""Measurements as tables: both kinds are read, and anything else is refused."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import format_csv, read_csv
from pipeline.measured import measurement_columns, parse_measurement, read_measurement

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


def test_columns_are_found_as_in_files() -> None:
    """Case, blanks and invisible characters of names do not matter; lists and whole numbers will do."""
    given = {"\ufeffT_S": [0, 1], " X_m": [1, 2], "y_m": [1, 2], "z_m": [1, 2], "rx_rad": [0, 0], "rz_rad": [0, 0]}
    read = parse_measurement(given, 1.0)
    assert read.controlled is not None
    assert read.controlled[:, 0].tolist() == [1.0, 2.0]
    assert read.place(1) == "index 1"


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"x2_m": np.zeros(2)}, "same number of rows: t_s 3, .* x2_m 2"),
        ({"x2_m": np.zeros((3, 1))}, "x2_m must be one-dimensional"),
        ({"x2_m": np.zeros(3) * 1j}, "x2_m holds values that are not finite numbers: .* complex"),
        ({"x2_m": np.array([0.0, np.inf, np.nan])}, "inf at index 1, and 1 more"),
        ({"t_s": np.array([0.0, 0.5, 0.5])}, r"index 2: .*0.5 is there twice \(so 1 times\).\n.*more decimals"),
        ({"t_s": np.array([0.0, 0.7, 0.5])}, r"index 2: .*0.5 follows 0.7.*\n.*sort the rows"),
        (
            {"t_s": np.array([0.0, 500.0, 1000.0])},
            r"index 1: .*\n  They look like milliseconds.\n.*divide t_s by 1000\.",
        ),
        ({"t_s": np.array([0.0, 5e5, 1e6])}, "They look like microseconds"),
        (
            {"t_s": np.array([1.7e9, 1.7e9 + 0.5, 1.7e9 + 1.0])},
            r"lasts 1 s \(3 rows outside\).\n.*count t_s from the start",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_place(change: dict[str, np.ndarray], expected: str) -> None:
    """Other shapes, gaps, and times that repeat, run backwards or have another unit are told apart."""
    with pytest.raises(UsageError, match=expected):
        parse_measurement({**measurement_columns(T, POSITIONS), **change}, 1.0)


@pytest.mark.parametrize("duration_s", [np.nan, np.inf, -1.0])
def test_a_motion_has_a_duration(duration_s: float) -> None:
    """Whether times are within the motion cannot be told without."""
    with pytest.raises(UsageError, match="duration"):
        parse_measurement(measurement_columns(T, POSITIONS), duration_s)


def test_files_are_read_with_lines(tmp_path: Path) -> None:
    """What is wrong with times is told by file and line."""
    file = tmp_path / "seen.csv"
    table = format_csv(measurement_columns(T, POSITIONS))
    file.write_text("Tracker\n\n" + table, encoding="utf-16")
    read = read_measurement(file, 1.0)
    assert np.array_equal(read.t_s, T)
    assert read.place(0) == f"{file}, line 4"
    file.write_text("Tracker\n\n" + table.replace("0.5", "0.0"))
    with pytest.raises(UsageError, match=f"{file}, line 5: times in t_s must increase"):
        read_measurement(str(file), 1.0)
    with pytest.raises(FileNotFoundError):
        read_measurement(tmp_path / "none.csv", 1.0)
