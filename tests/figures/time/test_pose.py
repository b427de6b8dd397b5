"""The pose over time with the steps of the route."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.time.pose import pose_figure
from pipeline.machine import MODES, Machine, inverse_kinematics
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import TrajectorySamples
from pipeline.route.result import Route


@pytest.fixture(scope="module")
def figure(
    agder_config: Config, machine: Machine, route: Route, coarse: PathSamples, trajectory: TrajectorySamples
) -> Figure:
    """Draw the trajectory over the route."""
    return pose_figure(agder_config, machine, route, coarse, trajectory)


def circles_of(axes: Axes) -> list[np.ndarray]:
    """Give the rows (t, value) of each coordinate's circles."""
    return [line.get_xydata() for line in axes.get_lines() if line.get_marker() == "o"]


def test_curves_are_the_samples(figure: Figure, trajectory: TrajectorySamples) -> None:
    """x, y, z in metres, rx and rz in degrees, over seconds."""
    position, angle = figure.axes
    np.testing.assert_array_equal([line.get_ydata() for line in position.get_lines()[:3]], trajectory.pose[:, :3].T)
    tilts = np.rad2deg(trajectory.pose[:, [3, 5]]).T
    np.testing.assert_allclose([line.get_ydata() for line in angle.get_lines()[:2]], tilts)
    assert [axes.get_ylabel() for axes in figure.axes] == ["position (m)", "angle (deg)"]
    assert angle.get_xlabel() == "time (s)"


def test_every_step_has_its_circles(figure: Figure, route: Route, trajectory: TrajectorySamples) -> None:
    """Values are the route's; times ascend from the start to the goal."""
    position, angle = (circles_of(axes) for axes in figure.axes)
    assert (len(position), len(angle)) == (3, 2)
    np.testing.assert_array_equal([circles[:, 1] for circles in position], route.pose[:, :3].T)
    for circles in (*position, *angle):
        assert circles[0, 0] == 0.0
        assert circles[-1, 0] == pytest.approx(trajectory.duration_s)
        assert (np.diff(circles[:, 0]) > 0.0).all()


def test_modes_are_named_and_their_changes_marked(
    agder_config: Config, machine: Machine, route: Route, coarse: PathSamples, trajectory: TrajectorySamples
) -> None:
    """Where arm 1 goes over to the other side there is a line, and both modes stand on top."""
    half = len(trajectory) // 2
    modes = np.where(np.arange(len(trajectory)) < half, MODES.index("LLL"), MODES.index("RLL"))
    solution = inverse_kinematics(machine, trajectory.pose[:, [0, 1, 2, 3, 5]], modes)
    fields = {**vars(trajectory), "pose": solution.pose, "q_m": solution.q_m}
    figure = pose_figure(agder_config, machine, route, coarse, TrajectorySamples(**fields))
    assert [text.get_text() for text in figure.axes[0].texts] == ["LLL", "RLL"]
    for axes in figure.axes:
        (line,) = [line for line in axes.get_lines() if len(line.get_xdata()) == 2]
        assert line.get_xdata()[0] == trajectory.t_s[half]


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Panels, labels and legend keep off each other and stay on the page."""
    assert_laid_out(figure)
