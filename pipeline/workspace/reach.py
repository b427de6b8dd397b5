"""The part of the YZ plane that a machine can use without tilt."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.workspace.usable import usable_windows

STEP_M = 0.04
"""Default grid step: fine enough for a table of a machine."""


@dataclass(frozen=True)
class Reach:
    """The part of the YZ plane usable without tilt in one working mode: (least, largest), None if it is empty."""

    x_m: tuple[float, float] | None
    y_m: tuple[float, float] | None
    z_m: tuple[float, float] | None
    area_m2: float


def usable_reach(machine: Machine, mode: int, kappa_max: float, step_m: float = STEP_M) -> Reach:
    """Measure on a grid where the machine is usable at some x.

    Parameters
    ----------
    mode : int
        Working mode, 0 (LLL) to 7 (RRR).
    step_m : float
        Grid step in y and z.
    """
    size = np.nansum([np.nanmax(machine.lengths_m), np.linalg.norm(machine.platform_points_m, axis=1).max()])
    low, high = machine.rails_m.min(axis=0) - size, machine.rails_m.max(axis=0) + size
    y, z = (np.arange(a, b, step_m) for a, b in zip(low, high, strict=True))
    controlled = np.zeros((len(y) * len(z), 5))
    controlled[:, 1:3] = np.stack(np.meshgrid(y, z), axis=-1).reshape(-1, 2)
    windows = usable_windows(machine, kappa_max, controlled, np.full(len(controlled), mode))
    usable = np.isfinite(windows[:, 0])
    if not usable.any():
        return Reach(None, None, None, 0.0)
    y, z = controlled[usable, 1], controlled[usable, 2]
    return Reach(_span(windows[usable]), _span(y), _span(z), len(y) * step_m**2)


def _span(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())
