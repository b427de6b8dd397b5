"""What is commanded: a trajectory sampled at the controllers' period, with the forces that the model expects."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from pipeline.arguments import require_number
from pipeline.arrays import FloatArray
from pipeline.retime import Trajectory, sample_trajectory, whole_periods
from pipeline.retime.path_dynamics import TABLE_POINTS, dynamics_table
from pipeline.simulate.plant import require_masses

LONGEST_PERIOD_S = 1e-3
"""Controllers run at least this often, and the machine is integrated in steps of at most this."""
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Motion:
    """A commanded motion of n rows, a period apart, from rest to rest.

    Attributes
    ----------
    period_s : float
        Time between two rows.
    t_s : (n,)
        Time since the start.
    q_m, qd_mps, qdd_mps2 : (n, 5)
        Actuators, their velocities and accelerations.
    pose : (n, 6)
        Poses of the model.
    drive_n, link_n : (n, 5), (n, 6)
        Forces of the model without friction, of drives and along links.
    middle_n, middle_mps, middle_mps2 : (n, 5)
        Drive forces, velocities and accelerations in the middle of the period after a row: what is held over a period
        is best fed forward for its middle.
    """

    period_s: float
    t_s: FloatArray
    q_m: FloatArray
    qd_mps: FloatArray
    qdd_mps2: FloatArray
    pose: FloatArray
    drive_n: FloatArray
    link_n: FloatArray
    middle_n: FloatArray
    middle_mps: FloatArray
    middle_mps2: FloatArray

    def __len__(self) -> int:
        return len(self.t_s)


def steps_of(period_s: float) -> int:
    """Count the steps of integration in a period of the controllers."""
    return max(1, ceil(period_s / LONGEST_PERIOD_S - _SAME))


def controller_period(period_s: float) -> float:
    """Divide the period of a trajectory into the fewest equal parts that a controller can run at."""
    return period_s / steps_of(period_s)


def plan_motion(trajectory: Trajectory, period_s: float) -> Motion:
    """Sample a trajectory of a machine with masses, stretched to whole periods, with its forces.

    Raises
    ------
    ArgumentError
        For a period that is not finite and more than 0.
    UsageError
        For a machine without masses.
    UnfitConfigError
        When it has more periods than a table may have rows.
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    require_masses(trajectory.path.machine)
    period_s = require_number("period_s", period_s, above=0.0)
    trajectory = whole_periods(trajectory, period_s)
    samples = sample_trajectory(trajectory, period_s)
    middle = (samples.t_s + period_s / 2.0).clip(max=samples.duration_s)
    forces, between = _forces(trajectory, samples.t_s), _forces(trajectory, middle)
    return Motion(
        period_s=period_s,
        t_s=samples.t_s,
        q_m=samples.q_m,
        qd_mps=samples.qd_mps,
        qdd_mps2=samples.qdd_mps2,
        pose=samples.pose,
        drive_n=forces[:, :5],
        link_n=forces[:, 5:],
        middle_n=between[:, :5],
        middle_mps=trajectory.q(middle, 1),
        middle_mps2=trajectory.q(middle, 2),
    )


def _forces(trajectory: Trajectory, t_s: FloatArray) -> FloatArray:
    """Forces of drives and along links without friction, a sdd + b sd^2 + c. Shape (n, 11)."""
    path = dynamics_table(trajectory.path, TABLE_POINTS).at(trajectory.s(t_s))
    sd, sdd = trajectory.s(t_s, 1)[:, None], trajectory.s(t_s, 2)[:, None]
    return np.asarray(path.a * sdd + path.b * sd**2 + path.c)
