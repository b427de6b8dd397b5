"""The usable workspace as maps of the YZ plane: the usable length along x of each working mode, and of all together."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from pipeline.arrays import FloatArray
from pipeline.figures import style
from pipeline.machine.geometry import MODES
from pipeline.workspace.usable import Workspace

_COLUMNS = 3
_ROWS = 3
_MARGIN_M = 0.03


@style.styled
def workspace_figure(workspace: Workspace) -> Figure:
    """Draw nine maps of one colour scale: the usable length along x in the eight working modes and in their union.

    The title of a panel states its volume; cells that cannot be used are white. All show the extent of the union.
    """
    maps = [*workspace.lengths_m, workspace.union_m]
    volumes = [*workspace.volumes_m3.tolist(), workspace.union_m3]
    window = _window(workspace)
    width, height = np.diff(window, axis=1).ravel()
    panel_in = (style.WIDTH_IN - 0.65) / _COLUMNS * height / width
    figure = style.new_figure(float(_ROWS * (panel_in + 0.2) + 0.75))
    panels = list(figure.subplots(_ROWS, _COLUMNS, sharex=True, sharey=True).flat)
    scale = Normalize(0.0, max(float(workspace.union_m.max(initial=0.0)), workspace.setting.step_m))
    for axes, name, a_map, volume in zip(panels, (*MODES, "all modes"), maps, volumes, strict=True):
        image = _draw_panel(axes, workspace, a_map, scale)
        axes.set_title(f"{name}: {volume:.3f} m³")
        axes.set(xlim=window[0], ylim=window[1])
    style.label_yz_panels(panels, _COLUMNS)
    bar = figure.colorbar(image, ax=panels, location="bottom", aspect=40, pad=0.02)
    bar.set_label("usable length along x (m)")
    return figure


def _window(workspace: Workspace) -> FloatArray:
    """Compute the least and largest y and z of the cells in use, with a margin; of all cells if none is. (2, 2)."""
    used = workspace.union_m > 0.0
    spans = []
    for centres, along in ((workspace.y_m, used.any(axis=0)), (workspace.z_m, used.any(axis=1))):
        shown = centres[along] if along.any() else centres
        spans.append((shown[0] - _MARGIN_M, shown[-1] + _MARGIN_M))
    return np.array(spans)


def _draw_panel(axes: Axes, workspace: Workspace, a_map: FloatArray, scale: Normalize) -> AxesImage:
    half = 0.5 * workspace.setting.step_m
    y, z = workspace.y_m, workspace.z_m
    axes.grid(False)
    return axes.imshow(
        np.where(a_map > 0.0, a_map, np.nan),
        cmap="viridis_r",
        norm=scale,
        origin="lower",
        extent=(y[0] - half, y[-1] + half, z[0] - half, z[-1] + half),
        interpolation="nearest",
    )
