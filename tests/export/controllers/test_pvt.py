"""Tables of position, velocity and time: what a controller drives between their rows."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from pipeline.export import ExportOptions, ExportRequest, read_csv
from pipeline.export.controllers.pvt import format_pvt, read_pvt
from pipeline.export.formats import LengthUnit, Separator, Times
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])


def test_rows_are_time_then_position_and_velocity_of_each_axis(make_samples) -> None:
    """Interleaved, with units in the names, of the length asked for."""
    samples = make_samples(0.01)
    options = ExportOptions(Separator.SEMICOLON, length=LengthUnit.MM)
    table = read_csv(format_pvt(ExportRequest(samples, LIMITS, ("a", "b", "c", "d", "e"), options)), ";")
    assert list(table) == [
        "t_s", "a_mm", "a_mmps", "b_mm", "b_mmps", "c_mm", "c_mmps", "d_mm", "d_mmps", "e_mm", "e_mmps",
    ]  # fmt: skip
    assert table["d_mmps"] == pytest.approx(1e3 * samples.qd_mps[:, 3], abs=1e-9)


def test_relative_times_add_up(make_samples) -> None:
    """The first row is at zero, every other one a period after the row before."""
    samples = make_samples(0.01)
    text = format_pvt(ExportRequest(samples, LIMITS, ACTUATORS, ExportOptions(times=Times.RELATIVE)))
    times = read_csv(text)["dt_s"]
    assert times[0] == 0.0
    assert times[1:] == pytest.approx(0.01, abs=1e-12)
    assert read_pvt(text).t_s == pytest.approx(samples.t_s, abs=1e-9)


def test_names_of_columns_are_free(make_samples) -> None:
    """A controller's own header."""
    names = ("T", "X", "VX", "Y", "VY", "Z", "VZ", "A", "VA", "B", "VB")
    text = format_pvt(ExportRequest(make_samples(0.01), LIMITS, ACTUATORS, ExportOptions(names=names)))
    assert text.splitlines()[0] == ",".join(names)


def test_cubics_between_the_rows_keep_the_motion(reference: TrajectorySamples) -> None:
    """A controller's cubics between every second row of the reference motion, 20 ms apart, meet the others to 2 um."""
    motion = read_pvt(format_pvt(ExportRequest(reference, LIMITS, ACTUATORS)))
    assert motion.qd_mps is not None
    cubics = CubicHermiteSpline(motion.t_s[::2], motion.q_m[::2], motion.qd_mps[::2])
    inside = reference.t_s <= motion.t_s[::2][-1]
    assert np.abs(cubics(reference.t_s) - reference.q_m)[inside].max() < 2e-6
