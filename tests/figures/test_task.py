"""The machine at start and goal, and its platform larger."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures.silhouettes import project
from pipeline.figures.task import task_figure
from pipeline.machine import Machine
from pipeline.machine.drawing import drawn_points
from pipeline.machine.geometry import LINKS
from pipeline.route.result import Route


@pytest.mark.parametrize("which", ["machine", "bodies_machine"])
def test_the_platform_is_drawn_larger(
    request: pytest.FixtureRequest,
    which: str,
    route: Route,
    quick_config: Config,
    assert_laid_out: Callable[[Figure], None],
) -> None:
    """Below each machine there is its platform with the names of its joints, all of them in sight."""
    drawn: Machine = request.getfixturevalue(which)
    pose, q = route.pose[[0, -1]], route.q_m[[0, -1]]
    figure = task_figure(quick_config, drawn, pose, q, ["start, LLL", "goal, LLL"])
    whole, near = figure.axes[:2], figure.axes[2:]
    assert [axes.get_title() for axes in whole] == ["start, LLL", "goal, LLL"]
    for k, axes in enumerate(near):
        assert [text.get_text() for text in axes.texts] == [*LINKS, "0.1 m"]
        assert np.ptp(axes.get_xlim()) < 0.5 * np.ptp(whole[k].get_xlim())
        joints = project(drawn_points(drawn, pose[k], q[k]).platform_joints_m)
        low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
        assert (joints > low).all()
        assert (joints < high).all()
    outlines = sum(isinstance(artist, PolyCollection) and len(artist.get_paths()) for artist in near[0].collections)
    lines = [len(artist.get_segments()) for artist in near[0].collections if isinstance(artist, LineCollection)]
    assert (outlines > 100, 4 in lines) == ((True, False) if drawn.bodies else (False, True))
    assert_laid_out(figure)
