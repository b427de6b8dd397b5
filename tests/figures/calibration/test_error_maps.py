"""Errors over the workspace."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from pipeline.calibrate.predict.maps import ErrorMap, ErrorMaps
from pipeline.figures.calibration import error_maps_figure


def test_panels_before_and_after(assert_laid_out: Callable[[Figure], None]):
    """A panel for every mode before, and one after with the measured poses; what is missing has none."""
    y, z = np.linspace(0.0, 1.0, 11), np.linspace(0.5, 1.0, 6)
    after = np.full((6, 11), 2e-5)
    after[0] = np.nan
    maps = tuple(
        ErrorMap(mode, 50.0 * after, after * (1 + k), np.array([[0.5, 0.7]] * k).reshape(-1, 2))
        for k, mode in enumerate(("LLL", "LRL", "LRR", "RRL", "RRR"))
    )
    figure = error_maps_figure(ErrorMaps(y, z, maps))
    assert_laid_out(figure)
    panels = [axes for axes in figure.axes if axes.images]
    titles = [f"{one.mode} {what}" for what in ("configured", "calibrated") for one in maps]
    assert [axes.get_title() for axes in panels] == titles
    np.testing.assert_allclose(panels[-1].images[0].get_array().filled(np.nan), 1e3 * maps[-1].calibrated_m)
    assert [len(axes.lines[0].get_xdata()) for axes in panels[5:]] == [0, 1, 2, 3, 4]
