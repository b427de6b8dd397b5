"""Positions of actuators as the controller has them, and in the geometry of the machine.

With the middle m of its travel or stroke, the zero z and the scale s of an actuator,

    q_geometry = m + z + s (q_controller - m).

Planning knows the geometry alone; what is written for a controller, or measured with its encoders, is converted.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import MachineConfig


@dataclass(frozen=True, eq=False)
class ControllerUnits:
    """Zeros and scales of the five actuators c1, c2, c3, l2b, l3b.

    Attributes
    ----------
    middles_m : (5,)
        Middles of their travels and strokes.
    zeros_m, scales : (5,)
        What a calibration found.
    """

    middles_m: FloatArray
    zeros_m: FloatArray
    scales: FloatArray

    def to_geometry(self, q_m: FloatArray) -> FloatArray:
        """Convert the controller's positions (..., 5) to those of the geometry."""
        moved: FloatArray = (q_m - self.middles_m) * self.scales + (self.middles_m + self.zeros_m)
        # Identity has to be exact: adding and subtracting the middle rounds.
        return np.where(self._is_identity, q_m, moved)

    def to_controller(self, q_m: FloatArray) -> FloatArray:
        """Convert positions of the geometry (..., 5) to the controller's."""
        moved: FloatArray = (q_m - (self.middles_m + self.zeros_m)) / self.scales + self.middles_m
        return np.where(self._is_identity, q_m, moved)

    def rates_to_controller(self, rates: FloatArray) -> FloatArray:
        """Convert velocities, accelerations or jerks (..., 5) of the geometry to the controller's."""
        return rates / self.scales

    @property
    def _is_identity(self) -> FloatArray:
        return np.asarray((self.zeros_m == 0.0) & (self.scales == 1.0))


def controller_units(config: MachineConfig) -> ControllerUnits:
    """Read zeros and scales off the configuration of a machine."""
    ranges = [rail.travel_m for rail in config.rails] + [config.links.l2b.stroke_m, config.links.l3b.stroke_m]
    given = config.actuators.in_order()
    return ControllerUnits(
        middles_m=np.mean(ranges, axis=1),
        zeros_m=np.array([one.zero_m for one in given]),
        scales=np.array([one.scale for one in given]),
    )
