"""Directions in which the path leaves the start and reaches the goal: from the TCP to the actuators."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import RY
from pipeline.machine.symbolic import closure_terms_function
from pipeline.route.result import Route

_POSE = 6
_LEAST_PIVOT = 1e-6
"""Singular value of the equations below which an arm is at its gate: the actuators cannot move the TCP freely."""


def end_directions(config: Config, machine: Machine, route: Route) -> FloatArray:
    """Compute unit vectors of actuator motion at start and goal, NaN where the end is free. Shape (2, 5).

    The TCP moves in the configured direction and the platform does not tilt: with p1 = (d, 0, ry1, 0) the derivative
    of the closure, F_p p1 + F_q q1 = 0, is six linear equations for ry1 and q1.

    Raises
    ------
    ConfigError
        If a direction is configured where an arm is at its gate.
    """
    found = np.full((2, 5), np.nan)
    for row, (end, key) in enumerate(((0, "start_direction"), (-1, "goal_direction"))):
        direction = getattr(config.refine, key)
        if direction is None:
            continue
        z = np.concatenate([route.pose[end], route.q_m[end]])
        by_z = np.array(closure_terms_function(machine)(z, np.zeros(11), np.zeros(11))[0])
        unknown = np.column_stack([by_z[:, RY], by_z[:, _POSE:]])
        if np.linalg.svd(unknown, compute_uv=False)[-1] < _LEAST_PIVOT:
            raise ConfigError(
                [ConfigIssue(f"refine.{key}", "cannot be kept: an arm is at right angles to its rail there")]
            )
        along = np.array(direction) / np.linalg.norm(direction)
        q1 = np.linalg.solve(unknown, -by_z[:, :3] @ along)[1:]
        found[row] = q1 / np.linalg.norm(q1)
    return found
