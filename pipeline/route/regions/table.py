"""The region table: one row per region, columns as arrays."""

from dataclasses import dataclass, fields

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import full_pose
from pipeline.machine.samples import PoseSamples


@dataclass(frozen=True, eq=False)
class RegionTable:
    """One row per region; the last two rows are the start and the goal.

    Attributes
    ----------
    controlled : (n, 5)
        x, y, z, rx, rz; x is zero but for the start and the goal.
    ry_rad : (n,)
        The dependent angle.
    modes, gates : (n,)
        Working mode 0 to 7; arm (1 to 3) at its serial singularity, 0 for none.
    q_m : (n, 5)
        Actuator positions at that x.
    kappa, det_sign, link_distance_m : (n,)
        Condition number, sign of det H, least distance between axes.
    x_window_m : (n, 2)
        Least and largest x with all carts on their rails; for start and goal their own x.
    visits : (n,)
        Which entry of `task.visit` the row was laid out for, counted from 1; 0 for none.
    """

    controlled: FloatArray
    ry_rad: FloatArray
    modes: IntArray
    gates: IntArray
    q_m: FloatArray
    kappa: FloatArray
    det_sign: FloatArray
    link_distance_m: FloatArray
    x_window_m: FloatArray
    visits: IntArray

    def __len__(self) -> int:
        return len(self.modes)

    @property
    def start(self) -> int:
        """Row of the start."""
        return len(self) - 2

    @property
    def goal(self) -> int:
        """Row of the goal."""
        return len(self) - 1

    @property
    def gate_count(self) -> int:
        """Number of gate regions."""
        return int(np.count_nonzero(self.gates))

    @property
    def pose(self) -> FloatArray:
        """Poses (x, y, z, rx, ry, rz), shape (n, 6)."""
        return full_pose(self.controlled, self.ry_rad)

    def samples(self, machine: Machine) -> PoseSamples:
        """Return poses and actuators as samples of the machine, with kappa and the sign of det H as they are here."""
        return PoseSamples(machine, self.pose, self.q_m).with_known(kappa=self.kappa, det_sign=self.det_sign)

    def take(self, rows: IntArray | BoolArray | slice) -> "RegionTable":
        """The table with only these rows."""
        return RegionTable(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @classmethod
    def concatenate(cls, tables: "list[RegionTable]") -> "RegionTable":
        """Put tables one below the other; the last one's last rows are the start and the goal."""
        return cls(**{f.name: np.concatenate([getattr(table, f.name) for table in tables]) for f in fields(cls)})
