"""The map of kappa around the machine, for its tilt and working mode, as a picture."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm, to_rgba

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.maps.kappa_map import YzWindow, kappa_map
from pipeline.figures.maps.panels import COLORMAP
from pipeline.machine.geometry import Machine
from pipeline.report.motion import singular_loops

_POINTS_Y, _POINTS_Z = 110, 90
_LEAST_KAPPA = 5.0
"""Where the colours begin: one scale for all tilts and modes."""
_MARGIN_M = 0.05
_ALPHA = 0.85


@dataclass(frozen=True, eq=False)
class MapPicture:
    """A picture of the YZ plane.

    Attributes
    ----------
    image : (nz, ny, 4)
        Red, green, blue and opacity, 0 to 255, the largest z first.
    loops_yz : (m, 2, 2)
        Pieces of the curves det H = 0: both ends of each.
    """

    image: IntArray
    loops_yz: FloatArray


def map_window(config: Config, machine: Machine) -> YzWindow:
    """Bound what is shown: the grid of the route, and the rails."""
    y, z = config.route.grid.y_m, config.route.grid.z_m
    low, high = machine.rails_m.min(axis=0), machine.rails_m.max(axis=0)
    ends = min(y.min, low[0]), max(y.max, high[0]), min(z.min, low[1]), max(z.max, high[1])
    return YzWindow(*(float(end + sign * _MARGIN_M) for end, sign in zip(ends, (-1, 1, -1, 1), strict=True)))


def map_picture(config: Config, machine: Machine, tilt_rad: tuple[float, float], mode: int) -> MapPicture:
    """Draw kappa for a tilt (rx, rz) and a working mode: dark is near a singularity, transparent is out of reach."""
    window = map_window(config, machine)
    y = np.linspace(window.y_least, window.y_largest, _POINTS_Y)
    z = np.linspace(window.z_least, window.z_largest, _POINTS_Z)
    found = kappa_map(machine, y, z, tilt_rad, mode)
    cap = max(config.route.kappa_max, 2.0 * _LEAST_KAPPA)
    colours = mpl.colormaps[COLORMAP](LogNorm(_LEAST_KAPPA, cap, clip=True)(found.kappa).filled(0.0))
    colours[..., 3] = _ALPHA
    colours[~np.isfinite(found.kappa)] = to_rgba(style.LIGHT_GREY, 0.25)
    loops = singular_loops(found)
    pieces = np.stack([loops[:-1], loops[1:]], axis=1)
    return MapPicture(np.rint(255.0 * colours[::-1]).astype(np.uint8), pieces[np.isfinite(pieces).all(axis=(1, 2))])
