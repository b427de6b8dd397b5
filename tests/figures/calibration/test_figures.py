"""All figures of a calibration."""

import pytest

from pipeline.calibrate import Calibration, Verdict
from pipeline.cli.calibration.pictures import NAMES
from pipeline.figures.calibration import calibration_figure
from pipeline.figures.calibration.figures import CALIBRATION_FIGURES


def test_the_command_line_knows_all():
    """Without loading what draws them."""
    assert tuple(CALIBRATION_FIGURES) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_each_is_drawn_by_the_name_of_its_file(name: str, calibration: Calibration, verdict: Verdict):
    """From a calibration and its verdict."""
    assert calibration_figure(name, calibration, verdict).axes
