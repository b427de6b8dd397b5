"""How far poses are from where they were planned, along a path."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.correct.correction import controlled_errors


@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Errors of a motion against the planned one at the same s.

    Attributes
    ----------
    s : (n,)
        Path parameter.
    error : (n, 5)
        x, y, z, rx, rz as reached less as planned, in metres and radians.
    """

    s: FloatArray
    error: FloatArray

    @property
    def position_m(self) -> FloatArray:
        """Distances of the TCP from its planned place. Shape (n,)."""
        return np.asarray(np.linalg.norm(self.error[:, :3], axis=1))

    @property
    def tilt_rad(self) -> FloatArray:
        """Magnitudes of the errors of both tilts together. Shape (n,)."""
        return np.asarray(np.linalg.norm(self.error[:, 3:], axis=1))

    @property
    def rms_m(self) -> float:
        """Root mean square of the distances, over s."""
        return float(np.sqrt(np.mean(self.position_m**2)))

    @property
    def rms_rad(self) -> float:
        """Root mean square of the errors of tilts, over s."""
        return float(np.sqrt(np.mean(self.tilt_rad**2)))

    @property
    def largest_s(self) -> float:
        """Where the largest distance is."""
        return float(self.s[np.argmax(self.position_m)])

    def as_json(self) -> dict[str, float]:
        """Give the figures, in metres and radians."""
        return {
            "rms_m": self.rms_m,
            "largest_m": float(self.position_m.max()),
            "largest_s": self.largest_s,
            "rms_rad": self.rms_rad,
            "largest_rad": float(self.tilt_rad.max()),
            "largest_rad_s": float(self.s[np.argmax(self.tilt_rad)]),
        }


def pose_errors(s: FloatArray, reached: FloatArray, planned: FloatArray) -> PoseErrors:
    """Compare poses (n, 6) with those planned (n, 6) at s (n,)."""
    return PoseErrors(s, controlled_errors(reached, planned))
