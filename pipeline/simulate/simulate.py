"""Simulate the real machine and its drives while a motion is commanded, from standing to standing."""

from time import perf_counter

import casadi as ca
import numpy as np

from pipeline.arguments import require_number
from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import ForwardKinematicsError, NoSolutionError
from pipeline.machine.dynamics import holding_forces
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import forward_kinematics
from pipeline.machine.statics import statics_matrix
from pipeline.progress import QUIET, Monitor
from pipeline.simulate.controller import controller_start, feed_forward
from pipeline.simulate.drives import Drives
from pipeline.simulate.ending import Watch, arrival, determinants
from pipeline.simulate.forces import forces_of
from pipeline.simulate.motion import Motion
from pipeline.simulate.period import Looped, Records, block_function, start_state
from pipeline.simulate.plant import Plant, require_masses
from pipeline.simulate.result import Simulation, Verdict

STANDING_S = 1.0
"""How long the machine stands under control before the motion and after it."""
_BLOCK = 250
"""Periods that are simulated at a time, between two checks whether the motion is over."""


def simulate_motion(
    machine: Machine,
    plant: Plant,
    drives: Drives,
    motion: Motion,
    standing_s: float = STANDING_S,
    monitor: Monitor = QUIET,
) -> Simulation:
    """Simulate what the real machine does when a motion of the model is commanded, until it stands or cannot go on.

    It begins at rest in the pose that the real machine has with its actuators as commanded, with integrals that hold
    it there, as after standing for long.

    Raises
    ------
    ArgumentError
        For a time to stand that is not finite or below 0.
    NoSolutionError
        When the real machine cannot be assembled with the actuators as commanded at the start.
    UsageError
        For a machine without masses.
    """
    require_masses(plant.machine)
    standing_s = require_number("standing_s", standing_s, least=0.0)
    block = block_function(plant.machine, drives, motion.period_s, _BLOCK)
    standing = round(standing_s / motion.period_s)
    rows = np.arange(-standing, len(motion) + standing)
    references = _references(machine, drives, motion, rows)
    began = perf_counter()
    loop = _at_start(block, plant, drives, motion, references[0])
    references[:, :5] += plant.offsets_m
    planned_det_h = determinants(machine, motion.pose, motion.q_m)
    watch = Watch(machine, plant, drives, motion, planned_det_h)
    records, verdict = _run(loop, references, rows, watch, monitor)
    seconds = perf_counter() - began
    if verdict is None:
        verdict = arrival(plant, motion, records.q[-1], records.pose[-1], standing_s)
    done = len(records.q)
    kept = Records(*(values[min(standing, done - 1) : standing + len(motion)] for values in records))
    push, pull = drives.saturation_n
    return Simulation(
        machine=machine,
        plant=plant,
        drives=drives,
        motion=motion,
        q_m=kept.q - plant.offsets_m,
        qd_mps=kept.qd,
        qdd_mps2=kept.qdd,
        pose=kept.pose,
        drive_n=kept.force,
        friction_n=kept.grip,
        link_n=forces_of(plant.machine, kept.pose, kept.q, kept.qd, kept.qdd).link_n,
        det_h=determinants(plant.machine, kept.pose, kept.q),
        planned_det_h=planned_det_h[: len(kept.q)],
        saturated=((kept.force >= push) | (kept.force <= -pull)).astype(float),
        verdict=verdict,
        simulated_s=done * motion.period_s,
        seconds=seconds,
    )


def _references(machine: Machine, drives: Drives, motion: Motion, rows: IntArray) -> FloatArray:
    """Positions, velocities and forces that are commanded, from standing to standing. Shape (n, 15)."""
    feed = feed_forward(drives, motion.middle_n, motion.middle_mps, motion.middle_mps2)
    at = rows.clip(0, len(motion) - 1)
    commanded: FloatArray = np.hstack([motion.q_m, motion.qd_mps, feed])[at]
    for row, which in ((0, rows < 0), (-1, rows >= len(motion) - 1)):
        held = drives.force_forward * _holding(machine, motion.pose[row], motion.q_m[row])
        commanded[which, 5:] = np.concatenate([np.zeros(5), held])
    return commanded


def _holding(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Forces of the drives (5,) that hold a machine in a pose (6,)."""
    H = statics_matrix(machine, pose[None], q_m[None, :3])
    held: FloatArray = holding_forces(machine, machine.known_masses, pose[None], H).drive_n[0]
    return held


def _at_start(block: ca.Function, plant: Plant, drives: Drives, motion: Motion, reference: FloatArray) -> Looped:
    q = motion.q_m[0] + plant.offsets_m
    try:
        pose = forward_kinematics(plant.machine, q[None], motion.pose[0])[0]
    except ForwardKinematicsError as error:
        raise NoSolutionError(
            "simulate",
            f"the real machine cannot be assembled with its actuators as commanded at the start: {error}",
            "Choose a smaller deviation of the geometry (--geometry), or another seed (--seed).",
        ) from None
    held = _holding(plant.machine, pose, q)
    controller = controller_start(drives, motion.period_s, q, held)
    controller[:5] = np.where(drives.integral_gain_npm > 0.0, held - reference[10:], 0.0)
    return Looped(plant.machine, block, start_state(q, pose, held), controller)


def _run(
    loop: Looped, references: FloatArray, rows: IntArray, watch: Watch, monitor: Monitor
) -> tuple[Records, Verdict | None]:
    """Run block by block, until something is wrong or the motion is over."""
    blocks: list[Records] = []
    for first in range(0, len(rows), _BLOCK):
        part = references[first : first + _BLOCK]
        missing = _BLOCK - len(part)
        records = loop.run(np.vstack([part, np.repeat(part[-1:], missing, axis=0)]))
        records = Records(*(values[: len(part)] for values in records))
        verdict, last = watch.check(records, part, rows[first : first + _BLOCK])
        blocks.append(Records(*(values[:last] for values in records)))
        monitor.progress("simulating", (first + len(part)) / len(rows))
        if verdict is not None:
            break
    return Records(*(np.concatenate(values) for values in zip(*blocks, strict=True))), verdict
