"""How the machine may be assembled where its encoders show q: all poses on its branch, for a tracker to choose from.

A table of poses all over the frame, by inverse kinematics, gives guesses: those whose carts and telescopes are most
alike, moved along X. Newton's method takes them to q. Kept are poses with the triangle as configured and the sign of
det H of the start of the task, which no motion without a Type-II singularity can change.
"""

import numpy as np
from scipy.spatial import KDTree

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.machine.geometry import (
    MODES,
    PRIMARY,
    TRIANGLE,
    Machine,
    build_machine,
    cart_joints,
    cross,
    dot,
    platform_arms,
    rotation,
)
from pipeline.machine.kinematics import inverse_kinematics, newton
from pipeline.machine.pose import wrap_angle
from pipeline.machine.statics import det_sign, statics_matrix

_PLACES, _TILTS = 16, 5
"""Steps of the table across the frame and of the tilts."""
_GUESSES = 64
_CLOSED_M = 1e-9
_SAME = 1e-5
"""Poses that differ less, in metres and radians, are one."""
_MORE_TILT = 1.3
"""How much more tilted than the task allows a pose may be."""


def assemblies(config: Config, q_m: FloatArray) -> list[FloatArray]:
    """Find poses (k, 6) of the configured machine for each of actuators (n, 5) in its geometry; k may be 0."""
    machine = build_machine(config.machine)
    poses, at = _table(config, machine)
    relative = KDTree(_relative(at))
    _, nearest = relative.query(_relative(q_m), k=min(_GUESSES, len(at)))
    nearest = nearest.reshape(len(q_m), -1)
    guess = poses[nearest]
    guess[..., 0] += (q_m[:, None, :3] - at[nearest][..., :3]).mean(axis=-1)
    rows = np.repeat(np.arange(len(q_m)), nearest.shape[1])
    with np.errstate(all="ignore"):
        found, miss = newton(machine, q_m[rows], guess.reshape(-1, 6))
    found[:, 3:] = wrap_angle(found[:, 3:])
    good = (miss < _CLOSED_M) & (np.abs(found[:, [3, 5]]).max(axis=1) < _MORE_TILT * _largest_tilt(config))
    rows, found = rows[good], found[good]
    kept = _on_branch(config, machine, found, q_m[rows])
    rows, found = rows[kept], found[kept]
    return [_distinct(found[rows == row]) for row in range(len(q_m))]


def _table(config: Config, machine: Machine) -> tuple[FloatArray, FloatArray]:
    """Give poses (m, 6) all over the frame in all working modes, x = 0, and their actuators (m, 5)."""
    reach = float(np.nanmax(machine.lengths_m))
    low, high = machine.rails_m.min(axis=0) - reach, machine.rails_m.max(axis=0) + reach
    y, z = (np.linspace(a, b, _PLACES) for a, b in zip(low, high, strict=True))
    tilts = np.linspace(-1.0, 1.0, _TILTS) * _largest_tilt(config)
    mesh = np.meshgrid([0.0], y, z, tilts, tilts, np.arange(len(MODES)), indexing="ij")
    *controlled, modes = (axis.ravel() for axis in mesh)
    found = inverse_kinematics(machine, np.column_stack(controlled), modes)
    telescopes = found.q_m[:, 3:]
    slack = np.ptp(machine.strokes_m, axis=1)
    with np.errstate(invalid="ignore"):
        near = (telescopes > machine.strokes_m[:, 0] - slack) & (telescopes < machine.strokes_m[:, 1] + slack)
    rows = np.flatnonzero(found.reachable & near.all(axis=1))
    return found.pose[rows], found.q_m[rows]


def _largest_tilt(config: Config) -> float:
    return float(np.deg2rad(max(config.task.tilt_max_deg, 10.0)))


def _relative(q_m: FloatArray) -> FloatArray:
    """What is left of actuators (n, 5) when all carts move alike. Shape (n, 4)."""
    return np.column_stack([q_m[:, 1] - q_m[:, 0], q_m[:, 2] - q_m[:, 0], q_m[:, 3:]])


def _on_branch(config: Config, machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Tell which poses (n, 6) have the triangle and the sign of det H of the start. Shape (n,)."""
    start = config.task.start
    there = inverse_kinematics(machine, controlled_pose(start)[None], np.array([MODES.index(start.mode)]))
    sign = det_sign(statics_matrix(machine, there.pose, there.q_m[:, :3]))[0]
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    arms, joints = platform_arms(machine, pose), cart_joints(machine, q_m[:, :3])
    side = arms[:, TRIANGLE] - arms[:, PRIMARY[2]]
    third = pose[:, :3] + arms[:, TRIANGLE] - joints[:, TRIANGLE]
    branch = dot(R[:, :, 1], cross(side, third)) * machine.triangle_sign > 0.0
    return np.asarray(branch & (det_sign(statics_matrix(machine, pose, q_m[:, :3])) == sign))


def _distinct(poses: FloatArray) -> FloatArray:
    kept: list[FloatArray] = []
    for pose in poses:
        if all(np.abs(pose - other).max() > _SAME for other in kept):
            kept.append(pose)
    return np.array(kept).reshape(-1, 6)
