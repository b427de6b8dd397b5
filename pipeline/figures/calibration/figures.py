"""All figures of a calibration: a row each."""

from collections.abc import Callable

from matplotlib.figure import Figure

from pipeline.calibrate import Calibration, Verdict
from pipeline.calibrate.predict.learning import learning_curves
from pipeline.calibrate.predict.maps import error_maps
from pipeline.figures.calibration.error_maps import error_maps_figure
from pipeline.figures.calibration.learning import learning_figure
from pipeline.figures.calibration.parameters import parameters_figure
from pipeline.figures.calibration.residuals import residuals_figure
from pipeline.figures.calibration.singular_values import singular_values_figure

CALIBRATION_FIGURES: dict[str, Callable[[Calibration, Verdict], Figure]] = {
    "residuals": lambda calibration, _: residuals_figure(calibration),
    "parameters": lambda calibration, _: parameters_figure(calibration),
    "singular_values": singular_values_figure,
    "workspace": lambda calibration, _: error_maps_figure(error_maps(calibration)),
    "poses": lambda calibration, _: learning_figure(learning_curves(calibration)),
}
"""How each figure is drawn, under the name of its file."""


def calibration_figure(name: str, calibration: Calibration, verdict: Verdict) -> Figure:
    """Draw a figure of a calibration, by the name of its file.

    Raises
    ------
    NoSolutionError
        When the machine has too few poses at which errors could be predicted.
    """
    return CALIBRATION_FIGURES[name](calibration, verdict)
