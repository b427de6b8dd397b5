"""Two reflectors on the platform: their places in its frame, and in space."""

from dataclasses import dataclass

import numpy as np

from pipeline.arguments import require_array, require_number
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.machine.geometry import rotation

_FARTHEST_M = 10.0
"""Largest coordinate of a reflector: no platform is as large, but one given in millimetres may be."""

_LEAST_NOISE_M = 1e-12
"""Least noise: dividing errors by less overflows."""


@dataclass(frozen=True, eq=False)
class Reflectors:
    """Places of the reflectors on the platform, and the noise with which a tracker measures them.

    The vector from the first to the second is best along the platform's y axis: then rx and rz do not depend on ry, and
    both are known equally well. It must not be parallel to the platform's x or z axis (the paper, section 5).

    Attributes
    ----------
    points_m : (2, 3)
        Both reflectors in the platform frame, from the TCP.
    noise_m : float
        Standard deviation of every measured coordinate; independent, zero mean. 0 if it is not known.

    Raises
    ------
    ArgumentError
        When places or noise are not finite, not in metres, or of another shape, or noise is negative or nearly 0.
    """

    points_m: FloatArray
    noise_m: float

    def __post_init__(self) -> None:
        require_places(require_array("points_m", self.points_m, (2, 3)))
        if require_number("noise_m", self.noise_m, least=0.0) != 0.0:
            require_number("noise_m", self.noise_m, least=_LEAST_NOISE_M)


def require_places(points_m: FloatArray) -> FloatArray:
    """Return places of reflectors in the platform frame (n, 3), which have to be near enough to be in metres.

    Raises
    ------
    ArgumentError
        When one is farther away than any platform is large.
    """
    for number, point in enumerate(np.asarray(points_m), 1):
        if np.abs(point).max() > _FARTHEST_M:
            raise ArgumentError(
                f"reflector {number} is at {_text(point)} m, farther than {_FARTHEST_M:g} m from the TCP.\n"
                "  What to change: give metres; these look like millimetres."
            )
    return points_m


def reflector_positions(points_m: FloatArray, pose: FloatArray) -> FloatArray:
    """Compute the positions P + R r_i of reflectors r_i (2, 3) for poses (n, 6). Shape (n, 2, 3)."""
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    return np.asarray(pose[:, None, :3] + points_m @ np.swapaxes(R, 1, 2))


def _text(point: FloatArray) -> str:
    return f"({', '.join(f'{value:g}' for value in point)})"
