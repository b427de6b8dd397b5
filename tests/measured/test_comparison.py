"""A measured motion against the commanded one, in numbers."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import format_csv
from pipeline.machine.pose import CONTROLLED
from pipeline.measured import (
    Measurement,
    MeasurementComparison,
    Reflectors,
    compare_measurement,
    error_rows,
    measurement_columns,
    read_measurement,
    reflector_positions,
)
from pipeline.measured.comparison import COORDINATES, TABLE_HEADER, table_cells

T = np.linspace(0.0, 1.0, 400)
POINTS = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])
POSE = np.column_stack([np.full(400, 1.0), 0.3 + 0.1 * T, 0.9 - 0.1 * T, -0.3 * T, 0.5 * T, 0.2 * T])


def noisy(noise_m: float) -> MeasurementComparison:
    """Compare a measurement that has noise and nothing else wrong."""
    positions = reflector_positions(POINTS, POSE)
    positions += np.random.default_rng(0).normal(0.0, noise_m, positions.shape)
    return compare_measurement(Measurement(T, positions, None), POSE, Reflectors(POINTS, noise_m))


def test_noise_alone_is_about_its_error_bar() -> None:
    """Where the machine follows its commands, root mean square errors are those of the noise."""
    for row in error_rows(noisy(1e-4)):
        assert row.standardised_rms == pytest.approx(1.0, abs=5.0 / np.sqrt(2.0 * len(T)))
        assert row.error_bar is not None
        assert row.rms == pytest.approx(row.error_bar, rel=0.2)


def test_an_offset_is_found() -> None:
    """A measured pose that is off by a constant has that for mean, rms and largest error, without error bars."""
    off = np.array([1e-3, -2e-3, 3e-3, -0.01, 0.02])
    comparison = compare_measurement(Measurement(T, None, POSE[:, CONTROLLED] + off), POSE, Reflectors(POINTS, 1e-4))
    rows = error_rows(comparison)
    assert [row.quantity for row in rows] == [row.name for row in COORDINATES]
    assert [row.mean for row in rows] == pytest.approx(off.tolist())
    assert [row.largest for row in rows] == pytest.approx(off.tolist())
    assert [row.rms for row in rows] == pytest.approx(np.abs(off).tolist())
    assert {row.error_bar for row in rows} == {row.standardised_rms for row in rows} == {None}


def test_the_largest_error_is_told_with_its_time() -> None:
    """Of a single wrong row sign and time are given."""
    measured = POSE[:, CONTROLLED].copy()
    measured[100, 2] -= 0.5
    row = error_rows(MeasurementComparison(T, POSE[:, CONTROLLED], measured, None))[2]
    assert (row.largest, row.largest_at_s) == (pytest.approx(-0.5), T[100])


def test_without_noise_there_are_no_error_bars() -> None:
    """A tracker without noise gives exact poses, and nothing to divide by."""
    comparison = noisy(0.0)
    assert comparison.std is None
    assert np.abs(comparison.error).max() < 1e-9


def test_cells_are_in_millimetres_and_degrees() -> None:
    """Every row has a text per heading, in the units people read; what is not known is a dash."""
    measured = POSE[:, CONTROLLED] + [1e-3, 0.0, 0.0, np.deg2rad(2.0), 0.0]
    cells = table_cells(error_rows(MeasurementComparison(T, POSE[:, CONTROLLED], measured, None)))
    assert {len(row) for row in cells} == {len(TABLE_HEADER)}
    assert cells[0][:4] == ("x", "mm", "+1.0000", "1.0000")
    assert cells[3][:4] == ("rx", "deg", "+2.0000", "2.0000")
    assert cells[0][6:] == ("-", "-")


def _reflectors() -> np.ndarray:
    return reflector_positions(POINTS, POSE)


def _beside(row: int) -> np.ndarray:
    positions = _reflectors()
    positions[row, 0] += 0.1
    return positions


@pytest.mark.parametrize(
    ("measurement", "expected"),
    [
        (Measurement(T, 1e3 * _reflectors(), None), "index 0: x1_m, y1_m, .*: values look like millimetres"),
        (
            Measurement(T, None, POSE[:, CONTROLLED] * [1, 1, 1, 57.2958, 57.2958]),
            "rx_rad, rz_rad: values look like deg",
        ),
        (Measurement(T, _reflectors()[::-1], None), "it is the other way"),
        (Measurement(T, None, POSE[::-1, CONTROLLED]), "it is the other way"),
        (Measurement(T, _beside(7), None), "index 7: the measured reflectors are"),
        (Measurement(T, _reflectors()[1:], None), "measured reflectors must have the shape"),
        (Measurement(T, None, POSE * np.nan), "measured poses must have the shape"),
        (Measurement(T, None, POSE[:, CONTROLLED] * np.nan), "measured poses are not finite at index 0"),
        (Measurement(T[1:], _reflectors(), None), "commanded poses must have the shape"),
        (Measurement(T, None, None), "needs positions of reflectors or poses"),
        (Measurement(T[:0], _reflectors()[:0], None), "no rows"),
    ],
)
def test_what_cannot_be_compared(measurement: Measurement, expected: str) -> None:
    """Other units, the other direction, other shapes and gaps are refused with the row."""
    with pytest.raises(UsageError, match=expected):
        compare_measurement(measurement, POSE, Reflectors(POINTS, 1e-4))


def test_lines_of_the_file_are_named(tmp_path: Path) -> None:
    """What is wrong with a row is told by its line, with lines that were skipped counted; the account goes along."""
    file = tmp_path / "seen.csv"
    for positions in (_beside(7), _reflectors()):
        file.write_text("Tracker\n" + format_csv(measurement_columns(T, positions)).replace("\n", "\n\n"))
        given = read_measurement(file, 1.0)
        try:
            comparison = compare_measurement(given, POSE, Reflectors(POINTS, 1e-4))
        except UsageError as error:
            assert str(error).startswith(f"{file}, line 18: the measured reflectors are")
    assert comparison.account is given.account
