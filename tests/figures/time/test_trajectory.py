"""The trajectory over time."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.figures.time.trajectory import trajectory_figure
from pipeline.machine import Machine
from pipeline.retime.result import TrajectorySamples


@pytest.fixture(scope="module")
def figure(machine: Machine, trajectory: TrajectorySamples) -> Figure:
    """Draw the trajectory."""
    return trajectory_figure(machine, trajectory)


def split(axes: Axes, count: int) -> tuple[list[np.ndarray], list[float]]:
    """Separate a panel's curves from its limits."""
    curves = [np.asarray(line.get_ydata()) for line in axes.get_lines()[:count]]
    return curves, [float(line.get_ydata()[0]) for line in axes.get_lines()[count:]]


def test_panels_and_units(figure: Figure) -> None:
    """Eight panels: pose, positions, velocities, accelerations; carts left, telescopes right."""
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "position (m)",
        "angle (deg)",
        "cart (m)",
        "telescope (m)",
        "velocity (m/s)",
        "velocity (m/s)",
        "acceleration (m/s²)",
        "acceleration (m/s²)",
    ]
    assert [axes.get_xlabel() for axes in figure.axes[-2:]] == ["time (s)"] * 2


def test_pose_is_drawn_whole(figure: Figure, trajectory: TrajectorySamples) -> None:
    """x, y, z in metres; rx, ry, rz in degrees; each named."""
    position, angle = figure.axes[:2]
    np.testing.assert_array_equal(split(position, 3)[0], trajectory.pose[:, :3].T)
    np.testing.assert_allclose(split(angle, 3)[0], np.rad2deg(trajectory.pose[:, 3:]).T)
    assert [text.get_text() for text in position.get_legend().get_texts()] == ["x", "y", "z"]
    assert [text.get_text() for text in angle.get_legend().get_texts()] == ["rx", "ry", "rz"]


@pytest.mark.parametrize(
    ("panel", "column", "attribute", "limits"),
    [
        (2, slice(0, 3), "q_m", [0.0, 2.1]),
        (3, slice(3, 5), "q_m", [0.95, 1.05, 1.25, 1.40]),
        (4, slice(0, 3), "qd_mps", [-0.5, 0.5]),
        (5, slice(3, 5), "qd_mps", [-0.1, 0.1]),
        (6, slice(0, 3), "qdd_mps2", [-2.0, 2.0]),
        (7, slice(3, 5), "qdd_mps2", [-0.5, 0.5]),
    ],
)
def test_actuators_and_their_limits(
    figure: Figure, trajectory: TrajectorySamples, panel: int, column: slice, attribute: str, limits: list[float]
) -> None:
    """Curves are the samples; a limit that all share is drawn once, others each, and all are in sight."""
    axes = figure.axes[panel]
    expected = getattr(trajectory, attribute)[:, column].T
    curves, drawn = split(axes, len(expected))
    np.testing.assert_array_equal(curves, expected)
    assert drawn == limits
    assert all(axes.get_ylim()[0] <= limit <= axes.get_ylim()[1] for limit in limits)


def test_limits_of_their_own_have_the_actuators_colour(figure: Figure) -> None:
    """The strokes differ, so that each telescope's dashed lines look like its curve; shared limits are grey."""
    lines = figure.axes[3].get_lines()
    assert [line.get_color() for line in lines[2:]] == [lines[0].get_color(), lines[1].get_color()] * 2
    assert figure.axes[5].get_lines()[2].get_color() not in [line.get_color() for line in lines[:2]]


def test_a_cart_with_a_limit_of_its_own(machine: Machine, trajectory: TrajectorySamples) -> None:
    """One shorter rail makes three upper limits, and the lower one stays shared."""
    travel = machine.travel_m.copy()
    travel[1, 1] = 1.9
    axes = trajectory_figure(dataclasses.replace(machine, travel_m=travel), trajectory).axes[2]
    assert split(axes, 3)[1] == [0.0, 2.1, 1.9, 2.1]


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Panels, labels and legends keep off each other and stay on the page; names stand above their curves."""
    assert_laid_out(figure)
    for axes in figure.axes[:4]:
        assert axes.get_legend().get_window_extent().y0 > axes.get_window_extent().y1
