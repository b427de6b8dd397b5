"""Residuals over poses."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from pipeline.calibrate import Calibration
from pipeline.figures.calibration import residuals_figure


def test_every_residual_is_there(calibration: Calibration, assert_laid_out: Callable[[Figure], None]):
    """A panel per reflector with x, y, z of all poses in micrometres, and a cross at the pose that was left out."""
    figure = residuals_figure(calibration)
    assert_laid_out(figure)
    for k, axes in enumerate(figure.axes):
        drawn = np.array([line.get_ydata() for line in axes.lines[1:4]]).T
        np.testing.assert_allclose(drawn, 1e6 * calibration.identification.residual_m[:, k])
        assert list(axes.lines[4].get_xdata()) == [5] * k
    assert [text.get_text() for text in figure.legends[0].get_texts()][-1] == "1 outlier"
