"""Margins that routes and paths keep from the ends of rails and strokes (`refine.travel_margin_m`, `stroke_margin_m`).

Limit switches and end stops are at these ends. Start, goal, their approach poses and poses to visit are given, and may
be nearer.
"""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig
from pipeline.limits.approach import approaches
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics


def margins_m(config: Config) -> FloatArray:
    """Return the configured margin of each actuator, shape (5, 1)."""
    return np.array([[config.refine.travel_margin_m]] * 3 + [[config.refine.stroke_margin_m]] * 2)


def within_margins(config: Config, machine: Machine) -> Machine:
    """Return the machine with travel and strokes shortened by the margins: what regions are computed for."""
    allowed = machine.actuator_limits_m + margins_m(config) * [1.0, -1.0]
    return replace(machine, travel_m=allowed[:3], strokes_m=allowed[3:])


def planned_range_m(config: Config, machine: Machine) -> FloatArray:
    """Return the range of each actuator that a path keeps: the machine's less the margins, where the task lets it.

    Least and largest position, shape (5, 2). An actuator that is nearer to an end of its range at the start, the goal
    a pose to visit or an approach pose keeps the distance that it has there.
    """
    allowed = within_margins(config, machine).actuator_limits_m
    q = given_positions_m(config, machine)
    q = np.clip(q[np.isfinite(q).all(axis=1)], *machine.actuator_limits_m.T)
    return np.column_stack([np.vstack([allowed[:, :1].T, q]).min(axis=0), np.vstack([allowed[:, 1:].T, q]).max(axis=0)])


def given_positions_m(config: Config, machine: Machine) -> FloatArray:
    """Compute the actuators at the given poses; NaN out of reach. Shape (n, 5)."""
    poses = given_poses(config).values()
    controlled = np.array([controlled_pose(pose) for pose in poses])
    solution = inverse_kinematics(machine, controlled, np.array([MODES.index(pose.mode) for pose in poses]))
    return np.where(solution.reachable[:, None], solution.q_m, np.nan)


def given_poses(config: Config) -> dict[str, PoseConfig]:
    """Return the start, the goal and the poses to visit by their keys, and the approach poses by what they are."""
    visits = {f"task.visit[{k}].pose": visit.pose for k, visit in enumerate(config.task.visit)}
    given = {key: pose for key, pose in visits.items() if pose is not None}
    given |= {approach.title: approach.pose for approach in approaches(config)}
    return {"task.start": config.task.start, "task.goal": config.task.goal, **given}


def controlled_pose(pose: PoseConfig) -> FloatArray:
    """Read x, y, z in metres and rx, rz in radians. Shape (5,)."""
    return np.array([pose.x_m, pose.y_m, pose.z_m, np.deg2rad(pose.rx_deg), np.deg2rad(pose.rz_deg)])
