"""Figures of a calibration: what was fitted, how sure it is, and what it lets expect."""

from pipeline.figures.calibration.error_maps import error_maps_figure
from pipeline.figures.calibration.figures import calibration_figure
from pipeline.figures.calibration.learning import learning_figure
from pipeline.figures.calibration.parameters import parameters_figure
from pipeline.figures.calibration.residuals import residuals_figure
from pipeline.figures.calibration.singular_values import singular_values_figure

__all__ = [
    "calibration_figure",
    "error_maps_figure",
    "learning_figure",
    "parameters_figure",
    "residuals_figure",
    "singular_values_figure",
]
