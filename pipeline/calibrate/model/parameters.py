"""What a calibration may change of a machine: a table of kinds, and the parameters of all kinds in one order.

Every parameter is a deviation from the configured machine, so that zero is the machine as configured.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.machine.geometry import ACTUATORS, LINKS

FIXED = np.array([0, 1, 3, 5])
"""The links of fixed length: 1, 2a, 3a, 3c."""
_LENGTH_STD_M, _SCALE_STD, _ANGLE_STD_RAD = 2e-4, 1e-4, 1e-4


class Kind(NamedTuple):
    """A kind of parameter: the word for it on the command line, its parameters, unit, and what is known beforehand.

    `std` is the standard deviation of what is known; infinite where nothing is.
    """

    key: str
    names: tuple[str, ...]
    unit: str
    std: float


def _points(what: str, subjects: tuple[str, ...], axes: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{what} {subject} {axis}" for subject in subjects for axis in axes)


PLATFORM = Kind("platform", _points("platform joint", LINKS), "m", _LENGTH_STD_M)
OFFSETS = Kind("offsets", _points("cart joint", LINKS), "m", _LENGTH_STD_M)
RAILS = Kind("rails", _points("rail", ("1", "2", "3"), "yz"), "m", _LENGTH_STD_M)
LENGTHS = Kind("lengths", tuple(f"length {LINKS[link]}" for link in FIXED), "m", _LENGTH_STD_M)
ZEROS = Kind("zeros", tuple(f"zero {name}" for name in ACTUATORS), "m", _LENGTH_STD_M)
SCALES = Kind("scales", tuple(f"scale {name}" for name in ACTUATORS), "1", _SCALE_STD)
DIRECTIONS = Kind("directions", _points("direction of rail", ("1", "2", "3"), "yz"), "rad", _ANGLE_STD_RAD)
REFLECTORS = Kind("reflectors", (), "m", _LENGTH_STD_M)
"""x, y, z of as many reflectors as there are."""
CLOCK = "clock offset"
CLOCKS = Kind("clocks", (), "s", np.inf)
"""Clock offsets of as many motions as there are; nothing is known of them."""
TRACKER = Kind("tracker", (*_points("tracker turned about", ("",)), *_points("tracker moved along", ("",))), "", np.inf)
"""Rotation vector and translation of the tracker's frame, of which nothing is known."""
KINDS = (PLATFORM, OFFSETS, RAILS, LENGTHS, ZEROS, SCALES, DIRECTIONS, REFLECTORS, CLOCKS, TRACKER)
CHOICES = tuple(kind.key for kind in KINDS if kind is not TRACKER)
"""Words for what can be fitted; the tracker's frame always is."""
USUAL = tuple(key for key in CHOICES if key != DIRECTIONS.key)
"""What is fitted unless asked otherwise: with rails as parallel as they are configured."""


@dataclass(frozen=True)
class Parameters:
    """The parameters of a machine with so many reflectors: 71, 74 and 77 with 1, 2 and 3.

    Attributes
    ----------
    reflector_count : int
        Number of reflectors on the platform.
    motion_count : int
        Number of motions with a clock offset: one more parameter each.
    """

    reflector_count: int
    motion_count: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Name all parameters, in order."""
        return tuple(name for kind in KINDS for name in self._names(kind))

    @property
    def units(self) -> tuple[str, ...]:
        """Give the unit of every parameter."""
        turned = self.slice(TRACKER).start
        return tuple(
            kind.unit or ("rad" if turned <= index < turned + 3 else "m") for index, kind in enumerate(self._kinds())
        )

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.names)

    def slice(self, kind: Kind) -> slice:
        """Where the parameters of a kind are."""
        before = KINDS[: KINDS.index(kind)]
        start = sum(len(self._names(one)) for one in before)
        return slice(start, start + len(self._names(kind)))

    def of(self, kind: Kind, values: FloatArray) -> FloatArray:
        """Pick the values of a kind from those of all parameters (..., count)."""
        return values[..., self.slice(kind)]

    def prior_std(self, given: Mapping[str, float]) -> FloatArray:
        """Give standard deviations of what is known beforehand, with those given for some kinds. Shape (count,)."""
        return np.array([given.get(kind.key, kind.std) for kind in self._kinds()])

    def is_fitted(self, keys: tuple[str, ...]) -> BoolArray:
        """Tell which parameters are of one of the kinds, or of the tracker. Shape (count,)."""
        return np.array([kind.key in keys or kind is TRACKER for kind in self._kinds()])

    def _kinds(self) -> list[Kind]:
        return [kind for kind in KINDS for _ in self._names(kind)]

    def _names(self, kind: Kind) -> tuple[str, ...]:
        if kind is CLOCKS:
            return tuple(f"{CLOCK} {number + 1}" for number in range(self.motion_count))
        if kind is not REFLECTORS:
            return kind.names
        return _points("reflector", tuple(str(number + 1) for number in range(self.reflector_count)))
