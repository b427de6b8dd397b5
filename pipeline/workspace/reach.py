"""The part of the YZ plane that a machine can use without tilt."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine import condition_number, inverse_kinematics, min_distances, statics_matrix
from pipeline.machine.geometry import Machine

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
    """Measure on a grid where arms reach, strokes, carts and clearances are kept, and kappa is within its cap.

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
    solution = inverse_kinematics(machine, controlled, np.full(len(controlled), mode))
    rows = np.flatnonzero(solution.reachable)
    pose, q = solution.pose[rows], solution.q_m[rows]
    # q was computed at x = 0, and all carts move with x.
    least = (machine.travel_m[:, 0] - q[:, :3]).max(axis=1)
    largest = (machine.travel_m[:, 1] - q[:, :3]).min(axis=1)
    strokes = machine.strokes_m
    usable = (least <= largest) & np.all((q[:, 3:] >= strokes[:, 0]) & (q[:, 3:] <= strokes[:, 1]), axis=1)
    kappa = condition_number(statics_matrix(machine, pose, q[:, :3]))
    links, rails = min_distances(machine, pose, q[:, :3])
    # Without a limit for rails theirs is NaN, and no distance is below it.
    usable &= (kappa <= kappa_max) & (links >= machine.link_link_m) & ~(rails < machine.link_rail_m)
    if not usable.any():
        return Reach(None, None, None, 0.0)
    x = np.concatenate([least[usable], largest[usable]])
    y, z = pose[usable, 1], pose[usable, 2]
    return Reach(_span(x), _span(y), _span(z), len(y) * step_m**2)


def _span(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())
