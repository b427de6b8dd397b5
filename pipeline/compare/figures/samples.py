"""What the figures read off samples of a path: where the route's steps are, and which working mode holds."""

import numpy as np

from pipeline.machine.geometry import PRIMARY, FloatArray, IntArray, Machine, link_vectors
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import TrajectorySamples
from pipeline.route.result import Route

_AT_GATE_M = 1e-6
"""An arm this close to its serial singularity is in neither mode: rounding would decide."""


def corner_samples(coarse: PathSamples, route: Route) -> IntArray:
    """Find the sample of the coarse path nearest in actuator space to each step of the route. Shape (n,).

    Where the route comes to the same place again, each step is found in its turn.
    """
    spacing = float(np.linalg.norm(np.diff(coarse.q_m, axis=0), axis=1).max())
    found = [0]
    for q in route.q_m:
        distance = np.linalg.norm(coarse.q_m[found[-1] :] - q, axis=1)
        passes = np.flatnonzero(distance <= distance.min() + spacing)
        first = passes[: 1 + int(np.argmax(np.append(np.diff(passes), 2) > 1))]
        found.append(found[-1] + int(first[np.argmin(distance[first])]))
    return np.array(found[1:])


def arm_sides(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Tell on which side the carts of poses (n, 6), actuators (n, 5) are: -1 (L) or +1 (R). Shape (n, 3)."""
    return np.where(_along(machine, pose, q_m) < 0.0, -1.0, 1.0)


def working_modes(machine: Machine, samples: PathSamples | TrajectorySamples) -> FloatArray:
    """Tell the mode of each arm along a path: -1 (L, cart at smaller x than the platform joint) or +1 (R).

    At a gate the arm keeps the mode it comes from. Shape (n, 3).
    """
    along = _along(machine, samples.pose, samples.q_m)
    decided = np.abs(along) > _AT_GATE_M
    rows = np.where(decided, np.arange(len(along))[:, None], 0)
    last_decided = np.maximum.accumulate(rows, axis=0)
    return np.where(np.take_along_axis(along, last_decided, axis=0) < 0.0, -1.0, 1.0)


def _along(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """By how much each cart's x exceeds that of its primary platform joint. Shape (n, 3)."""
    along: FloatArray = -link_vectors(machine, pose, q_m[:, :3])[:, PRIMARY, 0]
    return along


def mode_names(modes: FloatArray) -> list[str]:
    """Name working modes (n, 3) as given by `working_modes`: LLL to RRR, arm 1 first."""
    return ["".join("L" if sign < 0.0 else "R" for sign in row) for row in modes]
