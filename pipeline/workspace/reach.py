"""The part of the YZ plane that a machine can use without tilt."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.workspace.usable import usable_windows

STEP_M = 0.04
"""Least grid step: fine enough for a table of a machine."""
_MOST_POINTS = 40_000


@dataclass(frozen=True)
class Reach:
    """The part of the YZ plane usable without tilt in one working mode: (least, largest), None if it is empty."""

    x_m: tuple[float, float] | None
    y_m: tuple[float, float] | None
    z_m: tuple[float, float] | None
    area_m2: float


def reach_step(machine: Machine) -> float:
    """Choose a grid step for a machine: larger for a large one, so that it takes no longer."""
    return max(STEP_M, float(np.sqrt(np.prod(np.ptp(_extent(machine), axis=0)) / _MOST_POINTS)))


def usable_reach(machine: Machine, mode: int, kappa_max: float, step_m: float = STEP_M) -> Reach:
    """Measure on a grid where the machine is usable at some x.

    Parameters
    ----------
    mode : int
        Working mode, 0 (LLL) to 7 (RRR).
    step_m : float
        Grid step in y and z.
    """
    y, z = (np.arange(low, high, step_m) for low, high in _extent(machine).T)
    controlled = np.zeros((len(y) * len(z), 5))
    controlled[:, 1:3] = np.stack(np.meshgrid(y, z), axis=-1).reshape(-1, 2)
    windows = usable_windows(machine, kappa_max, controlled, np.full(len(controlled), mode))
    usable = np.isfinite(windows[:, 0])
    if not usable.any():
        return Reach(None, None, None, 0.0)
    y, z = controlled[usable, 1], controlled[usable, 2]
    return Reach(_span(windows[usable]), _span(y), _span(z), len(y) * step_m**2)


def _extent(machine: Machine) -> FloatArray:
    """Least and largest y and z beyond which no link reaches, as two rows. Shape (2, 2)."""
    size = np.nansum([np.nanmax(machine.lengths_m), np.linalg.norm(machine.platform_points_m, axis=1).max()])
    return np.array([machine.rails_m.min(axis=0) - size, machine.rails_m.max(axis=0) + size])


def _span(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())
