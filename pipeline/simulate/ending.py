"""How a simulated motion ends: at the goal, or by a drive that trips, or with a machine that is lost."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.errors import ForwardKinematicsError
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.kinematics import closure_residual, forward_kinematics
from pipeline.machine.statics import statics_matrix
from pipeline.simulate.drives import Drives
from pipeline.simulate.motion import Motion
from pipeline.simulate.period import Records
from pipeline.simulate.plant import Plant
from pipeline.simulate.result import Ending, Verdict

_MISSED_M = 1e-6
"""A pose that is integrated until it misses the lengths of links by this much is no pose of the machine."""
_STOPS_M = 2e-3
"""Assumed distance from the ends of travel and stroke to the mechanical stops."""
_AT_GOAL_M, _AT_GOAL_RAD = 0.01, np.deg2rad(1.0)
"""How far from where its actuators are commanded to put it a machine may stand at the end."""


@dataclass(frozen=True, eq=False)
class Watch:
    """Checks periods for what ends a motion early; `planned_det_h` (n,) is det H of the model along the motion."""

    machine: Machine
    plant: Plant
    drives: Drives
    motion: Motion
    planned_det_h: FloatArray

    def check(self, records: Records, references: FloatArray, rows: IntArray) -> tuple[Verdict | None, int]:
        """Find the first of the periods that ends the motion.

        Parameters
        ----------
        records : Records
            Of n periods.
        references, rows : (n, 15), (n,)
            What was commanded, in the actuators' own positions, and the rows of the motion.

        Returns
        -------
        verdict, rows : Verdict or None, int
            How it ends, and how many rows are left until then, at least one.
        """
        finite = np.isfinite(np.hstack([value.reshape(len(rows), -1) for value in records])).all(axis=1)
        known = len(rows) if finite.all() else int(np.argmin(finite))
        seen = Records(*(values[:known] for values in records))
        found = [
            *self._beyond_stops(seen),
            *self._singular(seen, rows[:known]),
            *self._tripped(seen, references[:known]),
            *self._not_followed(seen, known if known < len(rows) else None),
        ]
        if not found:
            return None, len(rows)
        row, ending, reason = min(found, key=lambda one: one[0])
        return Verdict(ending, float(rows[row] * self.motion.period_s), reason), max(min(row + 1, known), 1)

    def _tripped(self, records: Records, references: FloatArray) -> list[tuple[int, Ending, str]]:
        error = references[:, :5] - records.q
        return [
            (
                row,
                Ending.TRIPPED,
                f"the drive of {ACTUATORS[k]} trips: its following error is {1e3 * error[row, k]:+.1f} mm, allowed are "
                f"{1e3 * self.drives.trip_m[k]:g} mm",
            )
            for row, k in _first(np.abs(error) > self.drives.trip_m)
        ]

    def _beyond_stops(self, records: Records) -> list[tuple[int, Ending, str]]:
        q, (least, most) = records.q - self.plant.offsets_m, self.machine.actuator_limits_m.T
        return [
            (
                row,
                Ending.LOST,
                f"{ACTUATORS[k]} runs into its end stop: it is at {q[row, k]:.4f} m, allowed is {least[k]:g} to "
                f"{most[k]:g} m",
            )
            for row, k in _first((q < least - _STOPS_M) | (q > most + _STOPS_M))
        ]

    def _singular(self, records: Records, rows: IntArray) -> list[tuple[int, Ending, str]]:
        planned = self.planned_det_h[rows.clip(0, len(self.motion) - 1)]
        real = determinants(self.plant.machine, records.pose, records.q)
        return [
            (row, Ending.LOST, "the machine passes a Type-II singularity: the sign of det H changes")
            for row, _ in _first((planned * real <= 0.0)[:, None])
        ]

    def _not_followed(self, records: Records, infinite: int | None) -> list[tuple[int, Ending, str]]:
        reason = "the machine is at a Type-II singularity: its pose can no longer be followed"
        missed = np.abs(closure_residual(self.plant.machine, records.pose, records.q)) > _MISSED_M
        found = [(row, Ending.LOST, reason) for row, _ in _first(missed)]
        return found if infinite is None else [*found, (infinite, Ending.LOST, reason)]


def determinants(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Compute det H at poses (n, 6) with actuators (n, 5). Shape (n,)."""
    return np.asarray(np.linalg.det(statics_matrix(machine, pose, q_m[:, :3])))


def _first(wrong: BoolArray) -> list[tuple[int, int]]:
    """Give the first row in which something (n, k) is wrong, and the first column there; nothing if nothing is."""
    rows = np.flatnonzero(wrong.any(axis=1))
    return [(int(rows[0]), int(np.argmax(wrong[rows[0]])))] if rows.size else []


def arrival(plant: Plant, motion: Motion, q_m: FloatArray, pose: FloatArray, standing_s: float) -> Verdict:
    """Check where a machine stands at the end, with actuators (5,) in a pose (6,).

    It should be in the pose that the real machine has near the planned one with its actuators as commanded.
    """
    t = float(motion.t_s[-1]) + standing_s
    try:
        goal = forward_kinematics(plant.machine, (motion.q_m[-1] + plant.offsets_m)[None], motion.pose[-1])[0]
    except ForwardKinematicsError:
        reason = "the real machine cannot be assembled near the goal with its actuators as commanded"
        return Verdict(Ending.ELSEWHERE, t, reason)
    off = pose - goal
    distance, angle = float(np.linalg.norm(off[:3])), float(np.abs(off[3:]).max())
    if distance <= _AT_GOAL_M and angle <= _AT_GOAL_RAD:
        return Verdict(Ending.ARRIVED, t, "the machine stands at the goal")
    slip = float(np.abs(q_m - motion.q_m[-1] - plant.offsets_m).max())
    reason = (
        f"the machine ends {1e3 * distance:.1f} mm and {np.rad2deg(angle):.2f} degrees off the goal, "
        f"with actuators within {1e3 * slip:.2f} mm of what is commanded"
    )
    return Verdict(Ending.ELSEWHERE, t, reason)
