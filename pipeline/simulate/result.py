"""A simulated motion: what machine and drives did, and how it ended."""

from dataclasses import dataclass
from enum import StrEnum

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.simulate.drives import Drives
from pipeline.simulate.motion import Motion
from pipeline.simulate.plant import Plant


class Ending(StrEnum):
    """How a simulated motion ends."""

    ARRIVED = "arrived"
    TRIPPED = "tripped"
    LOST = "lost"
    ELSEWHERE = "elsewhere"


@dataclass(frozen=True)
class Verdict:
    """How a motion ended, when that was decided, seconds from its start, and why, in a sentence."""

    ending: Ending
    t_s: float
    reason: str

    @property
    def when(self) -> str:
        """Say when that was."""
        return f"after {self.t_s:.3f} s" if self.t_s >= 0.0 else "while standing at the start"

    @property
    def arrived(self) -> bool:
        """True when the machine stands at the goal."""
        return self.ending == Ending.ARRIVED


@dataclass(frozen=True, eq=False)
class Simulation:
    """What a machine did when a motion was commanded; fewer rows than the motion has where it ended early.

    Attributes
    ----------
    machine, plant, drives : Machine, Plant, Drives
        The model, the real machine, and its drives.
    motion : Motion
        What was commanded.
    q_m, qd_mps, qdd_mps2 : (n, 5)
        Actuators as encoders measure them, but exact, with velocities and accelerations.
    pose : (n, 6)
        Poses of the real machine.
    drive_n, friction_n : (n, 5)
        Forces of the drives, and what dry friction adds to them.
    link_n : (n, 6)
        Forces along the links.
    det_h, planned_det_h : (n,)
        Determinant of H of the real machine, and of the model where it was commanded to be.
    saturated : (n, 5)
        1 where a drive gave all it has, otherwise 0.
    verdict : Verdict
        How it ended.
    simulated_s, seconds : float
        Time that was simulated, standing before and after included, and time that took, compilation not included.
    """

    machine: Machine
    plant: Plant
    drives: Drives
    motion: Motion
    q_m: FloatArray
    qd_mps: FloatArray
    qdd_mps2: FloatArray
    pose: FloatArray
    drive_n: FloatArray
    friction_n: FloatArray
    link_n: FloatArray
    det_h: FloatArray
    planned_det_h: FloatArray
    saturated: FloatArray
    verdict: Verdict
    simulated_s: float
    seconds: float

    def __len__(self) -> int:
        return len(self.q_m)

    @property
    def t_s(self) -> FloatArray:
        """Time since the start. Shape (n,)."""
        return self.motion.t_s[: len(self)]

    @property
    def following_error_m(self) -> FloatArray:
        """Commanded minus real positions of the actuators. Shape (n, 5)."""
        return self.motion.q_m[: len(self)] - self.q_m

    @property
    def pose_error(self) -> FloatArray:
        """Real minus commanded poses (x, y, z, rx, ry, rz). Shape (n, 6)."""
        return self.pose - self.motion.pose[: len(self)]
