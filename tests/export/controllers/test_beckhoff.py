"""The CSV for Beckhoff's PLC functions: its dialect, and lines that FB_FileGets reads whole."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import ExportRequest, format_beckhoff, read_beckhoff
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])
T_MAX_STRING = 255


def test_the_beckhoff_dialect_is_as_documented(make_samples) -> None:
    """Semicolons, decimal points, CRLF, ASCII; units in the column names; zeros without a sign."""
    text = format_beckhoff(ExportRequest(make_samples(0.001), LIMITS, ("a", "b", "c", "d.x", "e")))
    assert text.isascii()
    assert text.count("\r\n") == text.count("\n") == 202
    assert text.endswith("\r\n")
    head, first, *_ = text.split("\r\n")
    assert head.startswith("Time_ms;a.Pos_mm;a.Vel_mmps;a.Acc_mmps2;b.Pos_mm")
    assert first.startswith("0.000000;300.000000000;0.000000000;")
    assert "-0.000000000;" not in text
    assert read_beckhoff(text).joint_names == ("a", "b", "c", "d.x", "e")


@pytest.mark.parametrize("period_s", [0.000125, 0.001, 0.01])
def test_no_line_is_longer_than_the_plc_reads(make_samples, period_s: float) -> None:
    """Longer lines would come as two, and every row be shifted."""
    text = format_beckhoff(ExportRequest(make_samples(period_s), LIMITS, ACTUATORS))
    assert max(map(len, text.split("\r\n"))) <= T_MAX_STRING


def test_lines_that_are_too_long_are_refused(make_samples) -> None:
    """Long names make a long header, huge values long rows: the message tells which, and what to change."""
    samples: TrajectorySamples = make_samples(0.01)
    with pytest.raises(UsageError, match=r"the header would have \d{3} characters.*\n.*export.joint_names"):
        format_beckhoff(ExportRequest(samples, LIMITS, [f"gantry_tau/{name}_joint" for name in ACTUATORS]))
    with pytest.raises(UsageError, match=r"row 3 would have \d{3} characters.*\n.*--period"):
        far = samples.q_m.copy()
        far[3] = 1e17
        format_beckhoff(ExportRequest(replace(samples, q_m=far), LIMITS, ACTUATORS))


def test_pandas_reads_it(reference: TrajectorySamples, tmp_path) -> None:
    """With semicolons as separators, all numbers come as floats, in millimetres."""
    pd = pytest.importorskip("pandas", reason="pandas is not installed: pip install '.[consumers]'")
    file = tmp_path / "motion.csv"
    file.write_bytes(format_beckhoff(ExportRequest(reference, LIMITS, ACTUATORS)).encode())
    table = pd.read_csv(file, sep=";")
    assert set(table.dtypes) == {np.dtype(float)}
    assert table["l2b.Vel_mmps"].to_numpy() == pytest.approx(1e3 * reference.qd_mps[:, 3], abs=1e-9)
