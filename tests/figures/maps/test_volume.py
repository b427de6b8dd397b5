"""The usable workspace in 3-D."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from pipeline.arrays import FloatArray
from pipeline.figures.maps.volume import shell, workspace_volume_figure
from pipeline.machine import MODES, Machine
from pipeline.workspace.usable import Workspace, WorkspaceSetting, usable_workspace


@pytest.fixture(scope="module")
def workspace(machine: Machine) -> Workspace:
    """Measure the reference machine on a coarse grid."""
    return usable_workspace(machine, WorkspaceSetting(step_m=0.04))


def enclosed_m3(workspace: Workspace, mode: int) -> float:
    """Volume between both ends of a shell: their areas in the YZ plane, first all left ones, times their mean x."""
    x, y, z = np.moveaxis(shell(workspace, mode), -1, 0)
    area = np.ptp(y, axis=1) * np.ptp(z, axis=1)
    ends = area > 1e-12
    left_and_right = (area * x.mean(axis=1))[ends].reshape(2, -1)
    return float(np.diff(left_and_right, axis=0).sum())


def edges(faces: FloatArray) -> dict[tuple[tuple[float, ...], ...], int]:
    """Count how many faces share each edge."""
    counts: dict[tuple[tuple[float, ...], ...], int] = {}
    for face in np.round(faces, 9):
        corners = [tuple(corner) for corner in face]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            key = tuple(sorted((a, b)))
            counts[key] = counts.get(key, 0) + 1
    return counts


@pytest.mark.parametrize("mode", ["LLL", "RRR", "RLL"])
def test_the_shell_is_closed_and_holds_the_volume(workspace: Workspace, mode: str) -> None:
    """Every edge belongs to an even number of faces, and what is enclosed is what the maps integrate to."""
    number = MODES.index(mode)
    assert all(count % 2 == 0 for count in edges(shell(workspace, number)).values())
    assert enclosed_m3(workspace, number) == pytest.approx(workspace.volumes_m3[number], rel=0.05)


def test_fine_grids_are_thinned(machine: Machine) -> None:
    """A grid ten times as fine is drawn with no more faces than fifty cells each way have."""
    faces = shell(usable_workspace(machine, WorkspaceSetting(step_m=0.01)), 0)
    assert len(faces) < 2 * 50 * 50
    assert np.isfinite(faces).all()


def test_both_are_drawn_in_order_of_distance(machine: Machine, workspace: Workspace) -> None:
    """Both bodies are one collection, with labelled axes and the volumes in the legend."""
    figure = workspace_volume_figure(machine, workspace)
    (axes,) = figure.axes
    (bodies,) = [artist for artist in axes.collections if isinstance(artist, Poly3DCollection)]
    assert len(bodies.get_facecolor()) == len(shell(workspace, 0)) + len(shell(workspace, 7))
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts[0] == f"all left (LLL): {workspace.volumes_m3[0]:.3f} m³"
    assert texts[2].endswith(f"{workspace.union_m3:.3f} m³")


def test_it_is_laid_out(machine: Machine, workspace: Workspace) -> None:
    """Axes with their labels stay on the page and off the legend, and nothing of the bodies is cut off."""
    figure = workspace_volume_figure(machine, workspace)
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    (axes,) = figure.axes
    (bodies,) = [artist for artist in axes.collections if isinstance(artist, Poly3DCollection)]
    legend = figure.legends[0].get_window_extent(renderer)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        box = axis.get_tightbbox(renderer)
        assert box.x0 > 0.0
        assert box.x1 < figure.bbox.width
        assert box.y1 < figure.bbox.height
        assert Bbox.intersection(box, legend) is None
    drawn = bodies.get_datalim(axes.transData).transformed(axes.transData)
    assert axes.bbox.x0 < drawn.x0
    assert drawn.x1 < axes.bbox.x1


def test_a_machine_that_reaches_nothing(machine: Machine) -> None:
    """Where nothing can be used there are rails alone; also where the arms do not even reach each other."""
    empty = usable_workspace(machine, WorkspaceSetting(kappa_max=1.0, step_m=0.1))
    workspace_volume_figure(machine, empty).draw_without_rendering()
    apart = replace(machine, rails_m=machine.rails_m + np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 0.0]]))
    nothing = usable_workspace(apart, WorkspaceSetting(step_m=0.1))
    assert nothing.union_m3 == 0.0
    workspace_volume_figure(apart, nothing).draw_without_rendering()
