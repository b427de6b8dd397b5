"""Changes of parameters beside what was known."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from pipeline.calibrate import Calibration
from pipeline.calibrate.model.parameters import CLOCKS
from pipeline.calibrate.report import FROM_DATA, sources
from pipeline.figures import style
from pipeline.figures.calibration import parameters_figure


def test_every_fitted_parameter_has_a_row(calibration: Calibration, assert_laid_out: Callable[[Figure], None]):
    """With its name, its change, a bar of what was known, and the colour of where it is from."""
    figure, found = parameters_figure(calibration), calibration.identification
    assert_laid_out(figure)
    fitted = np.flatnonzero(found.problem.is_fitted[: found.model.parameters.slice(CLOCKS).start])
    names = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
    assert names == [found.model.parameters.names[k] for k in fitted]
    marks = [line for axes in figure.axes for line in axes.lines if line.get_marker() == "o"]
    np.testing.assert_allclose([float(line.get_xdata()[0]) for line in marks], 1e6 * found.theta[fitted])
    told = sources(calibration)
    assert [line.get_color() == style.BLUE for line in marks] == [told[k] == FROM_DATA for k in fitted]
    widths = [bar.get_width() for axes in figure.axes for bar in axes.containers[0]]
    np.testing.assert_allclose(widths, 2e6 * found.problem.prior_std[fitted])
