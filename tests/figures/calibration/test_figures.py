"""All figures of a calibration."""

from pipeline.calibrate import Calibration, Verdict
from pipeline.cli.calibration.pictures import NAMES
from pipeline.figures.calibration import calibration_figures
from pipeline.progress import Monitor


def test_all_are_drawn_under_the_names_of_their_files(calibration: Calibration, verdict: Verdict):
    """One after the other, each announced; the command line knows the names beforehand."""
    said: list[float | None] = []
    monitor = Monitor(lambda message, fraction=None: said.append(fraction))
    names = [name for name, figure in calibration_figures(calibration, verdict, monitor) if figure.axes]
    assert tuple(names) == NAMES
    assert said == sorted(said)
    assert len(said) == len(NAMES)
