"""The picture of the usable workspace."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.maps.workspace import workspace_figure
from pipeline.machine import MODES, Machine
from pipeline.workspace.usable import Workspace, WorkspaceSetting, usable_workspace


@pytest.fixture(scope="module")
def workspace(machine: Machine) -> Workspace:
    """Measure the reference machine on a coarse grid."""
    return usable_workspace(machine, WorkspaceSetting(step_m=0.05))


def test_a_map_per_mode_and_one_of_all(workspace: Workspace) -> None:
    """Nine maps on one scale show the lengths that were computed, titled with mode and volume."""
    figure = workspace_figure(workspace)
    panels = [axes for axes in figure.axes if axes.get_title()]
    assert [axes.get_title().split(":")[0] for axes in panels] == [*MODES, "all modes"]
    assert panels[0].get_title() == f"LLL: {workspace.volumes_m3[0]:.3f} m³"
    images = [axes.get_images()[0] for axes in panels]
    for image, lengths in zip(images, [*workspace.lengths_m, workspace.union_m], strict=True):
        assert np.array_equal(np.ma.filled(image.get_array(), 0.0), lengths)
    assert len({image.get_clim() for image in images}) == 1
    assert figure.axes[-1].get_xlabel() == "usable length along x (m)"


def test_it_is_laid_out(workspace: Workspace, assert_laid_out: Callable[[Figure], None]) -> None:
    """The figure has the common width, and nothing covers anything."""
    figure = workspace_figure(workspace)
    assert figure.get_figwidth() == style.WIDTH_IN
    assert_laid_out(figure)


def test_an_empty_workspace_can_be_drawn(machine: Machine, assert_laid_out: Callable[[Figure], None]) -> None:
    """Where nothing is usable, the maps are empty."""
    figure = workspace_figure(usable_workspace(machine, WorkspaceSetting(kappa_max=1.0, step_m=0.1)))
    assert np.ma.getmaskarray(figure.axes[0].get_images()[0].get_array()).all()
    assert_laid_out(figure)
