"""Rails of a configuration and those of the model: the same lines, with other numbers.

A configuration has y and z where x is 0, and positions q of carts along the rail; the model has y and z at the middle m
of the travel, and x of carts. With the slopes s and the direction d of a rail, x = q d_x and, at the middle, y + s m.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Rails:
    """Three rails with the encoders of their carts.

    Attributes
    ----------
    places_m : (3, 2)
        y and z of each rail, where x is 0 or at the middle of the travel.
    slopes : (3, 2)
        dy/dx and dz/dx.
    middles_m, zeros_m, scales : (3,)
        What encoders show, see `ControllerUnits`: positions along the rail, or x.
    """

    places_m: FloatArray
    slopes: FloatArray
    middles_m: FloatArray
    zeros_m: FloatArray
    scales: FloatArray

    def at_middles(self) -> "Rails":
        """Convert from the numbers of a configuration to those of the model."""
        return self._converted(1.0, 1.0 / self._lengths)

    def at_origin(self) -> "Rails":
        """Convert from the numbers of the model to those of a configuration."""
        return self._converted(-1.0, self._lengths)

    @property
    def _lengths(self) -> FloatArray:
        """Metres along each rail per metre of x."""
        lengths: FloatArray = np.sqrt(1.0 + (self.slopes**2).sum(axis=1))
        return lengths

    def _converted(self, side: float, factor: FloatArray) -> "Rails":
        """Move y and z along the rails, and multiply middle + zero and scale by factors (3,); by 1 exactly."""
        return Rails(
            places_m=self.places_m + side * self.slopes * self.middles_m[:, None],
            slopes=self.slopes,
            middles_m=self.middles_m,
            zeros_m=self.zeros_m + (factor - 1.0) * (self.middles_m + self.zeros_m),
            scales=self.scales * factor,
        )
