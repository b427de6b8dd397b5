"""The coarse path: the route's steps joined by straight lines in actuator space, over arc length."""

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import follow
from pipeline.refine.result import Path
from pipeline.route.metric import arc_length
from pipeline.route.result import Route

SAMPLES_PER_MOVE = 100
"""Known poses of the coarse path from one step to the next."""
_ARRIVAL = 1e-6
"""How far, in metres and radians, a move may end from the next step of the route."""
_STILL = 1e-9
"""Share of the whole length below which a move counts as none: a visit may be where the route already is."""


def coarse_path(machine: Machine, route: Route, steps: FloatArray) -> Path:
    """Join the steps of a route; s is the arc length in the metric of the route, `steps` (5,) its largest moves.

    The nodes are dense samples followed along every move, so that the pose is known on the right branch everywhere.

    Raises
    ------
    NoSolutionError
        If a move, followed continuously, does not arrive at the next step: the route is not one of stage one.
    """
    part = np.linspace(0.0, 1.0, SAMPLES_PER_MOVE + 1)[:, None]
    q = route.q_m[:-1, None] * (1.0 - part) + route.q_m[1:, None] * part
    poses, misses = follow(machine, q, route.pose[:-1])
    _require_arrival(machine, poses, misses, route)
    lengths = np.array([arc_length(move, steps)[-1] for move in poses])
    moved = lengths > _STILL * lengths.sum()
    corners = np.append(0.0, np.cumsum(np.where(moved, lengths, 0.0)))
    corners /= corners[-1]
    # A knot must not repeat: a step at the same place as the one before shares its parameter and its knot.
    own = np.append(True, moved)
    node_s = corners[:-1, None] + part[:-1, 0] * np.diff(corners)[:, None]
    return Path(
        machine=machine,
        spline=BSpline(np.concatenate([[0.0], corners[own], [1.0]]), route.q_m[own], 1),
        node_s=np.append(node_s.ravel(), 1.0),
        node_pose=np.vstack([poses[:, :-1].reshape(-1, 6), route.pose[-1]]),
    )


def _require_arrival(machine: Machine, poses: FloatArray, misses: FloatArray, route: Route) -> None:
    lost = ~np.isfinite(misses).all(axis=1) | (np.abs(poses[:, -1] - route.pose[1:]).max(axis=1) > _ARRIVAL)
    if not lost.any():
        return
    reason = f"move {int(np.argmax(lost)) + 1} of the route cannot be followed from its first step to its second"
    advice = "Find the route again: it does not belong to this machine, or was changed."
    if not machine.has_parallel_rails:
        reason += " on the rails as they are; it was found for parallel ones"
        advice = "Choose a finer grid, so that moves are shorter, or align the rails (machine.rails.slopes)."
    raise NoSolutionError("refine", reason, advice)


def corner_parameters(coarse: Path) -> FloatArray:
    """Return the parameter s of every step of the route on its coarse path, shape (steps,)."""
    return coarse.node_s[::SAMPLES_PER_MOVE]


def move_of(coarse: Path, s: FloatArray) -> IntArray:
    """Return the number of the move that s (n,) falls into, from 0. Shape (n,)."""
    corners = corner_parameters(coarse)
    return np.clip(np.searchsorted(corners, s, side="right") - 1, 0, len(corners) - 2)
