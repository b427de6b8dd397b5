"""Figures of a simulated motion show what was simulated."""

import numpy as np
import pytest

from pipeline.figures.time.simulated import errors_figure, following_figure, forces_figure
from pipeline.machine import Machine
from pipeline.simulate import Deviations, Drives, Motion, Simulation, build_plant, simulate_motion
from tests.simulate.conftest import agder, drives, reference  # noqa: F401
from tests.simulate.motions import part


@pytest.fixture(scope="module")
def simulation(agder: Machine, drives: Drives, reference: Motion) -> Simulation:  # noqa: F811
    """Simulate a part of the reference motion that has a mode change."""
    plant = build_plant(agder, Deviations())
    return simulate_motion(agder, plant, drives, part(reference, 1_500, 2_500), standing_s=0.0)


def test_errors_are_drawn_with_mode_changes(simulation: Simulation) -> None:
    """Five rows of both motions and their difference, with a line at the mode change in each."""
    figure = errors_figure(simulation)
    assert len(figure.axes) == 10
    for k, axes in enumerate(figure.axes[1::2]):
        drawn = axes.lines[0].get_ydata()
        scale = 1e3 if k < 3 else 180.0 / np.pi
        assert np.allclose(drawn, scale * simulation.pose_error[:, [0, 1, 2, 3, 5][k]])
        assert any(list(line.get_xdata()) == [line.get_xdata()[0]] * 2 for line in axes.lines)
    assert figure.axes[1].get_title() == "simulated - commanded"


def test_following_errors_are_drawn(simulation: Simulation) -> None:
    """In millimetres, carts above telescopes, with what trips the drives."""
    above, below = following_figure(simulation).axes
    assert np.allclose(above.lines[1].get_ydata(), 1e3 * simulation.following_error_m[:, 1])
    assert np.allclose(below.lines[0].get_ydata(), 1e3 * simulation.following_error_m[:, 3])
    assert "20 mm" in above.get_title(loc="right")


def test_forces_are_drawn_beside_the_plan(simulation: Simulation) -> None:
    """Five drives and six links, simulated and planned."""
    axes = forces_figure(simulation).axes
    assert len(axes) == 11
    assert np.allclose(axes[3].lines[0].get_ydata(), simulation.drive_n[:, 3])
    assert np.allclose(axes[3].lines[1].get_ydata(), simulation.motion.drive_n[:, 3])
    assert np.allclose(axes[10].lines[0].get_ydata(), simulation.link_n[:, 5])
