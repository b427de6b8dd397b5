"""Tables as spreadsheets and data frames read them, in a German locale, too."""

import io

import numpy as np
import pytest

from pipeline.export import ExportOptions, ExportRequest, export_files, trajectory_columns
from pipeline.export.formats import DecimalMark, Format, LengthUnit, Separator
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

pd = pytest.importorskip("pandas", reason="pandas is not installed: pip install '.[consumers]'")
LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])
COMMA = DecimalMark.COMMA


def _written(samples: TrajectorySamples, options: ExportOptions, jerk: np.ndarray | None = None) -> str:
    request = ExportRequest(samples, LIMITS, ACTUATORS, options, jerk_mps3=jerk)
    return export_files(Format.CSV, request)[""].decode()


@pytest.mark.parametrize("separator", [Separator.SEMICOLON, Separator.TAB])
def test_pandas_reads_decimal_commas(reference: TrajectorySamples, separator: Separator) -> None:
    """Every column is of floats, equal to what a table with points gives, to the bit."""
    german = pd.read_csv(
        io.StringIO(_written(reference, ExportOptions(separator, decimal=COMMA))),
        sep=separator.character,
        decimal=",",
    )
    english = pd.read_csv(io.StringIO(_written(reference, ExportOptions())))
    assert set(german.dtypes) == {np.dtype(float)}
    pd.testing.assert_frame_equal(german, english, check_exact=True)
    for name, values in trajectory_columns(reference).items():
        assert german[name].to_numpy() == pytest.approx(values, abs=1e-12)


def test_polars_reads_decimal_commas(reference: TrajectorySamples) -> None:
    """So does another library, with its own parser."""
    polars = pytest.importorskip("polars", reason="polars is not installed: pip install '.[consumers]'")
    text = _written(reference, ExportOptions(Separator.SEMICOLON, decimal=COMMA))
    table = polars.read_csv(io.StringIO(text), separator=";", decimal_comma=True)
    assert set(table.dtypes) == {polars.Float64}
    for name, values in trajectory_columns(reference).items():
        assert table[name].to_numpy() == pytest.approx(values, abs=1e-12)


def test_a_robot_vendors_columns(make_samples) -> None:
    """Jerk beside the rest, under the vendor's names, in the order asked for, converted to millimetres."""
    samples = make_samples(0.01)
    jerk = np.arange(5.0 * len(samples)).reshape(-1, 5)
    columns, names = (
        ("t_s", "q2_m", "qd2_mps", "qdd2_mps2", "qddd2_mps3"),
        ("ts", "pts_J2", "vel_J2", "acc_J2", "jerk_J2"),
    )
    text = _written(samples, ExportOptions(columns=columns, names=names, length=LengthUnit.MM), jerk)
    table = pd.read_csv(io.StringIO(text))
    assert tuple(table) == names
    assert table["pts_J2"].to_numpy() == pytest.approx(1e3 * samples.q_m[:, 1], abs=1e-9)
    assert table["jerk_J2"].to_numpy() == pytest.approx(1e3 * jerk[:, 1], abs=1e-9)


def test_names_may_hold_separators(make_samples) -> None:
    """They are quoted then."""
    options = ExportOptions(Separator.SEMICOLON, columns=("t_s", "q1_m"), names=("time; s", 'x "m"'))
    assert _written(make_samples(0.1), options).splitlines()[0] == '"time; s";"x ""m"""'
