"""A motion that was driven while a tracker watched: what encoders showed at a time, as far as commands say it."""

from dataclasses import dataclass

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from pipeline.retime.result import Trajectory


@dataclass(frozen=True, eq=False)
class DrivenMotion:
    """The motion of a run as its controller commanded it; before it and after it the machine stands still.

    Attributes
    ----------
    trajectory : Trajectory
        The motion, in the geometry of the machine that it was planned for.
    units : ControllerUnits
        Zeros and scales that it was exported with.
    period_s : float
        Time between two rows of it.
    """

    trajectory: Trajectory
    units: ControllerUnits
    period_s: float

    def encoders(self, t_s: FloatArray) -> FloatArray:
        """Give what encoders showed at times (n,), if drives were where they were commanded. Shape (n, 5)."""
        return self.units.to_controller(self.trajectory.q(t_s))

    def encoder_rates(self, t_s: FloatArray) -> FloatArray:
        """Differentiate that by time. Shape (n, 5)."""
        return self.units.rates_to_controller(self.trajectory.q(t_s, 1))

    def pose(self, t_s: FloatArray) -> FloatArray:
        """Give the planned poses at times (n,). Shape (n, 6)."""
        return self.trajectory.pose(t_s)
