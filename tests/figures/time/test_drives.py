"""What the drives feel: what is drawn is what the trajectory does."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.interpolate import make_interp_spline

from pipeline.figures import drives_figure, has_masses
from pipeline.machine import Machine
from pipeline.refine.measure import PathSamples
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_drives
from pipeline.retime.fastest import plan


@pytest.fixture(scope="module")
def timed(machine: Machine, refined: PathSamples) -> Trajectory:
    """The refined path in time."""
    rows = np.arange(0, 101, 4)
    path = Path(machine, make_interp_spline(refined.s[rows], refined.q_m[rows], k=5), refined.s, refined.pose)
    return plan(path, 300)


def test_there_is_a_panel_for_each_figure(timed: Trajectory, assert_laid_out: Callable[[Figure], None]) -> None:
    """Five drives and the worst direction; stiffness in kN/m, with its limit once it is in sight."""
    figure = drives_figure(timed)
    masses, stiffness, damping, gains = figure.axes
    assert [len(axes.get_lines()) for axes in (masses, stiffness, damping, gains)] == [6, 1, 1, 2]
    felt = measure_drives(timed).felt
    assert felt is not None
    np.testing.assert_allclose(stiffness.get_lines()[0].get_ydata(), felt.stiffness_npm.value / 1e3)
    assert_laid_out(figure)
    least = 1.5 * float(felt.stiffness_npm.value.min())
    limited = replace(timed, path=replace(timed.path, machine=replace(timed.path.machine, gravity_stiffness_npm=least)))
    assert len(drives_figure(limited).axes[1].get_lines()) == 2


def test_without_masses_there_is_no_figure(timed: Trajectory) -> None:
    """There is nothing that the drives feel."""
    massless = replace(timed, path=replace(timed.path, machine=replace(timed.path.machine, masses=None)))
    assert has_masses(timed)
    assert not has_masses(massless)
    with pytest.raises(ValueError, match="without masses"):
        drives_figure(massless)
