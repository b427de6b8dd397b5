"""Errors by the number of poses."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from pipeline.calibrate.predict.learning import Learning
from pipeline.figures.calibration import learning_figure


def test_curves_continue_where_measuring_ended(assert_laid_out: Callable[[Figure], None]):
    """The next poses begin at the last measured one, whose error stands beside it; huge errors are left out."""
    numbers = np.arange(1.0, 32.0)
    curves = Learning(1e-2 / numbers[:21], 4e-3 / numbers[20:], 5e-3 / numbers, np.stack([1e-2 / numbers] * 3))
    figure = learning_figure(curves)
    assert_laid_out(figure)
    best, measured, further, mark = figure.axes[0].lines
    assert np.isnan(measured.get_ydata()[:4]).all()
    assert (measured.get_xdata()[-1], further.get_xdata()[0], mark.get_xdata()[0]) == (20, 20, 20)
    assert best.get_ydata()[-1] == 5.0 / 31.0
    assert [text.get_text() for text in figure.axes[0].texts] == ["0.476 mm"]
