"""The usable workspace in 3-D: the volumes of the modes with all arms left and all right, between the rails."""

from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from pipeline.arrays import BoolArray, FloatArray
from pipeline.figures import style
from pipeline.machine.drawing import rail_ends
from pipeline.machine.geometry import MODES, Machine
from pipeline.workspace.usable import Workspace

_SHOWN = (("LLL", "all left", style.BLUE), ("RRR", "all right", style.ORANGE))
_MOST_CELLS = 50
"""Largest number of cells along y or z that are drawn: more take long and look no better."""
_ALPHA = 0.6
_LIGHT = np.array([0.4, -0.6, 0.7]) / np.linalg.norm([0.4, -0.6, 0.7])
_DARKEST = 0.55
_MARGIN_M = 0.1
_NEIGHBOURS = (((0, -1), (0, 0), (1, 0)), ((0, 1), (0, 1), (1, 1)), ((-1, 0), (0, 0), (0, 1)), ((1, 0), (1, 0), (1, 1)))
"""For each neighbour (z, y) of a cell, both corners (z, y) of the edge they share."""


@style.styled
def workspace_volume_figure(machine: Machine, workspace: Workspace) -> Figure:
    """Draw the usable volumes of LLL and RRR as translucent bodies, and the rails.

    Where they overlap, either mode can be used. The legend has their volumes, and that of all eight modes together.
    """
    figure = Figure(figsize=(style.WIDTH_IN, 2.75), dpi=style.DPI)
    # 3-D axes are a square, half empty here, that clips what is beyond it: it may extend beyond the page.
    axes: Axes3D = figure.add_axes((-0.04, 0.1, 0.95, 1.0), projection="3d", proj_type="ortho", azim=-58.0, elev=20.0)
    axes.set_facecolor("none")
    shells = [shell(workspace, MODES.index(mode)) for mode, _, _ in _SHOWN]
    colours = [_shaded(faces, colour) for faces, (_, _, colour) in zip(shells, _SHOWN, strict=True)]
    # One collection for both: only faces of the same collection are drawn in the order of their distance.
    axes.add_collection3d(Poly3DCollection(np.concatenate(shells), facecolors=np.concatenate(colours), linewidths=0.0))
    rails = rail_ends(machine)
    for rail in rails:
        axes.plot(*rail.T, color=style.GREY, linewidth=1.2)
    _set_axes(axes, np.concatenate([rails.reshape(-1, 3), *(faces.reshape(-1, 3) for faces in shells)]))
    figure.legend(handles=_handles(workspace), loc="lower center", ncols=1)
    return figure


def shell(workspace: Workspace, mode: int) -> FloatArray:
    """Build the surface of the volume that a working mode can use, quadrilaterals (n, 4, 3): ends in x, and side walls.

    At most 50 cells along y and z are drawn. The ends of neighbouring cells meet in their mean.
    """
    every = -(-max(workspace.least_m.shape[1:]) // _MOST_CELLS)
    half = 0.5 * every * workspace.setting.step_m
    y, z = (centres[::every] for centres in (workspace.y_m, workspace.z_m))
    ends = [values[mode, ::every, ::every] for values in (workspace.least_m, workspace.largest_m)]
    used = np.isfinite(ends[0])
    if not used.any():
        return np.empty((0, 4, 3))
    corner_y, corner_z = np.meshgrid(*(np.concatenate([axis - half, axis[-1:] + half]) for axis in (y, z)))
    left, right = (np.stack([_at_corners(end), corner_y, corner_z], axis=-1) for end in ends)
    row, column = np.nonzero(used)
    faces = [
        np.stack([end[row + i, column + j] for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))], axis=1)
        for end in (left, right)
    ]
    for neighbour, (i, j), (k, m) in _NEIGHBOURS:
        row, column = np.nonzero(used & ~_shifted(used, neighbour))
        first, second = (row + i, column + j), (row + k, column + m)
        faces.append(np.stack([left[first], left[second], right[second], right[first]], axis=1))
    return np.concatenate(faces)


def _at_corners(values: FloatArray) -> FloatArray:
    """Average the up to four cells (nz, ny) around each corner that are not NaN; NaN if there are none."""
    padded = np.pad(values, 1, constant_values=np.nan)
    around = np.stack([padded[:-1, :-1], padded[1:, :-1], padded[:-1, 1:], padded[1:, 1:]])
    known = np.isfinite(around).sum(axis=0)
    total = np.nansum(around, axis=0)
    return np.asarray(np.divide(total, known, out=np.full(total.shape, np.nan), where=known > 0))


def _shifted(used: BoolArray, by: tuple[int, int]) -> BoolArray:
    """Look up, for every cell, whether the cell at an offset `by` (z, y) is used."""
    rows, columns = used.shape
    padded = np.pad(used, 1)
    return padded[1 + by[0] : 1 + by[0] + rows, 1 + by[1] : 1 + by[1] + columns]


def _shaded(faces: FloatArray, colour: str) -> FloatArray:
    """Shade faces (n, 4, 3) by a light from the front, above and right. Colours (n, 4)."""
    normals = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    bright = _DARKEST + (1.0 - _DARKEST) * np.abs(normals @ _LIGHT)
    return np.column_stack([bright[:, None] * np.array(to_rgb(colour)), np.full(len(faces), _ALPHA)])


def _set_axes(axes: Axes3D, points: FloatArray) -> None:
    """Show all points on one scale, with ticks every half metre."""
    low, high = points.min(axis=0) - _MARGIN_M, points.max(axis=0) + _MARGIN_M
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(tuple(high - low), zoom=1.1)
    each: tuple[Any, ...] = (axes.xaxis, axes.yaxis, axes.zaxis)
    for axis, name in zip(each, "xyz", strict=True):
        axis.set_major_locator(MultipleLocator(0.5))
        axis.set_tick_params(pad=-3.0)
        axis.set_label_text(f"{name} (m)")
        axis.labelpad = -4.0


def _handles(workspace: Workspace) -> list[Patch]:
    volumes = workspace.volumes_m3
    handles = [
        Patch(facecolor=colour, alpha=_ALPHA, label=f"{name} ({mode}): {volumes[MODES.index(mode)]:.3f} m³")
        for mode, name, colour in _SHOWN
    ]
    union = f"all eight working modes together: {workspace.union_m3:.3f} m³"
    return [*handles, Patch(facecolor="none", label=union)]
