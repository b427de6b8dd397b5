"""Singular values and gauges."""

from collections.abc import Callable
from dataclasses import replace

from matplotlib.figure import Figure

from pipeline.calibrate import Calibration, Verdict
from pipeline.figures.calibration import singular_values_figure


def texts(figure: Figure) -> list[str]:
    """Give what the legend says."""
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_directions_are_counted(calibration: Calibration, verdict: Verdict, assert_laid_out: Callable[[Figure], None]):
    """Those of the data are above one, those of the prior below, and gauges are the rest."""
    figure = singular_values_figure(calibration, verdict)
    assert_laid_out(figure)
    told, known = figure.axes[0].lines[:2]
    assert min(told.get_ydata()) > 1.0 >= max(known.get_ydata())
    assert len(told.get_xdata()) + len(known.get_xdata()) == verdict.rank
    assert texts(figure) == [
        f"from the data: {verdict.from_data}",
        f"from the prior: {verdict.rank - verdict.from_data}",
        "gauges: 21",
    ]


def test_what_poses_do_not_determine_is_told(calibration: Calibration, verdict: Verdict):
    """Apart from the gauges."""
    short = replace(verdict, rank=verdict.from_data, directions=verdict.from_data + 25)
    assert texts(singular_values_figure(calibration, short))[-1] == "gauges: 21, not determined: 4"
