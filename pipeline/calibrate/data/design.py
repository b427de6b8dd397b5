"""Poses that a machine can be measured at: at random, on its side of the Type-II singularities, within its limits."""

import numpy as np

from pipeline.arrays import IntArray
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits import admitted, pose_limits
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.limits.actuators import cart_travel
from pipeline.limits.bodies import obstacle_distance
from pipeline.machine.geometry import MODES, Machine, build_machine
from pipeline.machine.kinematics import InverseSolution, inverse_kinematics
from pipeline.machine.samples import PoseSamples
from pipeline.machine.statics import det_sign, statics_matrix

MODERATE = 25.0
"""Largest kappa of poses to measure first: near a singularity a machine that is 1 mm off may not assemble."""
_DRAWN = 20_000
_ROUNDS = 20


def random_poses(config: Config, count: int, random: np.random.Generator, kappa_max: float) -> InverseSolution:
    """Draw poses of the configured machine in all working modes, as many in each as can be had.

    All limits of a pose are kept, distances of bodies and obstacles among them, tilts are those of the task, and det H
    has the sign of task.start.
    Whether the machine can be driven from one to the next is not looked at.

    Raises
    ------
    NoSolutionError
        When there are not enough such poses.
    """
    machine = build_machine(config.machine)
    found: list[InverseSolution] = []
    modes = np.empty(0, dtype=int)
    for _ in range(_ROUNDS):
        more, kinds = _draw(config, machine, random, kappa_max)
        found.append(more)
        modes = np.concatenate([modes, kinds])
        if len(chosen := _spread(modes, count)) == count:
            return InverseSolution(
                *(
                    np.concatenate([getattr(one, name) for one in found])[chosen]
                    for name in ("pose", "q_m", "discriminants_m2", "reachable")
                )
            )
    raise NoSolutionError(
        "calibrate",
        f"{_ROUNDS * _DRAWN:,} poses at random have {len(modes)} that can be measured, with kappa up to {kappa_max:g}",
        "Ask for fewer, or check the machine's limits (gantry-tau check CONFIG).",
    )


def _draw(
    config: Config, machine: Machine, random: np.random.Generator, kappa_max: float
) -> tuple[InverseSolution, IntArray]:
    """Draw poses, and keep those that can be measured; with the working mode of each."""
    reach, tilt = float(np.nanmax(machine.lengths_m)), np.deg2rad(config.task.tilt_max_deg)
    low, high = machine.rails_m.min(axis=0) - reach, machine.rails_m.max(axis=0) + reach
    locked = np.array([axis in config.task.locked_axes for axis in ("rx", "rz")])
    controlled = np.column_stack(
        [
            random.uniform(machine.travel_m.min(), machine.travel_m.max(), _DRAWN),
            random.uniform(low, high, (_DRAWN, 2)),
            np.where(locked, 0.0, random.uniform(-tilt, tilt, (_DRAWN, 2))),
        ]
    )
    modes = random.integers(0, len(MODES), _DRAWN)
    solution = inverse_kinematics(machine, controlled, modes)
    rows = np.flatnonzero(solution.reachable)
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    on_side = samples.det_sign == sign_at_start(config, machine)
    limits = [
        cart_travel(machine),
        *pose_limits(machine, min(kappa_max, config.route.kappa_max)),
        *obstacle_distance.for_path(config, machine),
    ]
    rows = rows[on_side][admitted(limits, samples.take(on_side))[0]]
    picked = (getattr(solution, name)[rows] for name in ("pose", "q_m", "discriminants_m2", "reachable"))
    return InverseSolution(*picked), modes[rows]


def sign_at_start(config: Config, machine: Machine) -> float:
    """Give the sign of det H at task.start, which no motion without a Type-II singularity can change."""
    start = config.task.start
    there = inverse_kinematics(machine, controlled_pose(start)[None], np.array([MODES.index(start.mode)]))
    return float(det_sign(statics_matrix(machine, there.pose, there.q_m[:, :3]))[0])


def _spread(modes: IntArray, count: int) -> IntArray:
    """Choose rows so that every mode has as many as it can, and the most common has not more than it must."""
    order = np.empty(len(modes), dtype=int)
    for mode in np.unique(modes):
        rows = np.flatnonzero(modes == mode)
        order[rows] = np.arange(len(rows))
    return np.sort(np.argsort(order, kind="stable")[:count])
