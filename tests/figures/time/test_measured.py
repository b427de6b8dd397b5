"""The picture of a measured motion over the commanded one."""

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.time.measured import measured_figure
from pipeline.measured import Account, MeasurementComparison, Skipped


@pytest.fixture(scope="module")
def comparison() -> MeasurementComparison:
    """Give a motion of a second with errors of a millimetre and a hundredth of a radian."""
    t = np.linspace(0.0, 1.0, 201)
    commanded = np.column_stack([1.0 + 0.1 * t, 0.3 + 0.2 * t, 0.9 - 0.1 * t, -0.3 * t, 0.2 * t])
    error = np.sin(9.0 * t)[:, None] * [1e-3, 1e-3, 1e-3, 1e-2, 1e-2]
    return MeasurementComparison(t, commanded, commanded + error, np.tile([1e-4, 1e-4, 1e-4, 1e-3, 1e-3], (201, 1)))


def test_a_row_per_quantity(comparison: MeasurementComparison) -> None:
    """The left shows both motions in metres and degrees, the right their difference in millimetres and degrees."""
    figure = measured_figure(comparison)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels[::2] == ["x (m)", "y (m)", "z (m)", "rx (deg)", "rz (deg)"]
    assert labels[1::2] == ["x (mm)", "y (mm)", "z (mm)", "rx (deg)", "rz (deg)"]
    assert np.array_equal(figure.axes[0].lines[0].get_ydata(), comparison.commanded[:, 0])
    assert figure.axes[1].lines[0].get_ydata() == pytest.approx(1e3 * comparison.error[:, 0])
    assert figure.axes[7].lines[0].get_ydata() == pytest.approx(np.rad2deg(comparison.error[:, 3]))


def test_noise_is_a_band_of_two_standard_deviations(comparison: MeasurementComparison) -> None:
    """The band reaches two error bars up and down, and is named; without error bars there is none."""
    figure = measured_figure(comparison)
    heights = figure.axes[1].collections[0].get_paths()[0].vertices[:, 1]
    assert (heights.min(), heights.max()) == (pytest.approx(-0.2), pytest.approx(0.2))
    assert [text.get_text() for text in figure.legends[0].get_texts()][2:] == ["two standard deviations of noise"]
    bare = measured_figure(replace(comparison, std=None))
    assert not bare.axes[1].collections
    assert len(bare.legends[0].get_texts()) == 2


def test_rows_that_were_left_out_are_counted(
    comparison: MeasurementComparison, assert_laid_out: Callable[[Figure], None]
) -> None:
    """The legend says how many rows of the file had gaps; other lines are no rows."""
    account = Account(
        file="seen.csv",
        columns=("t_s",),
        encoding="UTF-8",
        separator=",",
        decimal_mark=".",
        line_count=206,
        header_line=2,
        row_lines=np.arange(6, 207),
        skipped=(Skipped("above the header", (1,)), Skipped("with a gap in t_s", (3, 4, 5), rows=True)),
    )
    figure = measured_figure(replace(comparison, account=account))
    assert [text.get_text() for text in figure.legends[0].get_texts()][3:] == ["left out: 3 rows with gaps"]
    assert_laid_out(figure)


def test_it_is_laid_out(comparison: MeasurementComparison, assert_laid_out: Callable[[Figure], None]) -> None:
    """The figure has the common width, and nothing covers anything."""
    figure = measured_figure(comparison)
    assert figure.get_figwidth() == style.WIDTH_IN
    assert_laid_out(figure)


def test_a_single_instant(comparison: MeasurementComparison) -> None:
    """One row, at the very start, can be drawn as well."""
    first = MeasurementComparison(np.zeros(1), comparison.commanded[:1], comparison.measured[:1], None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        measured_figure(first).draw_without_rendering()
