"""What the drives feel along a motion."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space import (
    Amplification,
    DriveFigures,
    actuator_rates,
    amplification,
    drive_figures,
)
from pipeline.retime.result import Trajectory

_INSTANTS = 2_001


@dataclass(frozen=True, eq=False)
class MotionDrives:
    """What the drives feel at n instants.

    Attributes
    ----------
    t_s, s : (n,), (n,)
        The instants, and the path parameter there.
    felt : DriveFigures or None
        Masses, stiffness and damping; None for a machine without masses.
    amplified : Amplification
        What the TCP does per movement of the actuators.
    """

    t_s: FloatArray
    s: FloatArray
    felt: DriveFigures | None
    amplified: Amplification


def measure_drives(trajectory: Trajectory) -> MotionDrives:
    """Evaluate what the drives feel, all along a trajectory.

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    machine = trajectory.path.machine
    t = np.linspace(0.0, trajectory.duration_s, _INSTANTS)
    rates = actuator_rates(machine, trajectory.pose(t), trajectory.q(t)[:, :3])
    felt = None if machine.masses is None else drive_figures(machine, rates, trajectory.q(t, 1))
    return MotionDrives(t, trajectory.s(t), felt, amplification(rates))
