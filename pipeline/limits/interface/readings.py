"""What a limit reads at a single pose: the quantity, what is allowed, and how much room is left."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from pipeline.limits.interface.limit import Curve, Limit, ShownLimit
from pipeline.limits.interface.measure import Measure
from pipeline.machine.samples import PoseSamples

NOT_CHECKED = "not checked"


@runtime_checkable
class ReadLimit(Protocol):
    """A limit whose quantities are read one by one at a pose, more precisely than its curves."""

    def readings(self, samples: PoseSamples) -> Sequence[Curve]:
        """The limited quantities at n poses, by names that say what is nearest to the limit at the first."""


@dataclass(frozen=True)
class Reading:
    """A limited quantity at one pose; a side without a limit is infinite.

    Attributes
    ----------
    name, unit : str
        What it is.
    value, least, largest : float
        The quantity, and its limits.
    allowed : str
        The limits in signs.
    key : str
        Configuration key of the limit.
    """

    name: str
    unit: str
    value: float
    least: float
    largest: float
    allowed: str
    key: str

    @property
    def margin(self) -> float:
        """How far the value is within its limits, negative beyond them, in its unit."""
        return min(self.value - self.least, self.largest - self.value)

    @property
    def room(self) -> float:
        """The margin without a unit, so that limits compare: 0 at the limit, negative beyond it, at most 1.

        Between two limits it is the part of the half range; with one limit L, |value - L| / max(|value|, |L|).
        """
        if np.isfinite([self.least, self.largest]).all():
            return 2.0 * self.margin / (self.largest - self.least)
        limit = self.least if np.isinf(self.largest) else self.largest
        if not np.isfinite(self.margin):
            return float(np.sign(self.margin))
        scale = max(abs(self.value), abs(limit))
        return min(self.margin / scale, 1.0) if scale > 0.0 else 0.0


def read_limits(limits: Iterable[Limit], samples: PoseSamples) -> list[Reading]:
    """Read all limits at a single pose (n = 1)."""
    found = []
    for limit in limits:
        for curve in _curves(limit, samples):
            value = float(curve.values[0])
            reading = Reading(
                curve.name, curve.unit, value, curve.least, curve.largest, curve.allowed, limit.wording.key
            )
            found.append(reading)
    return found


def read_measures(measures: Iterable[Measure], samples: PoseSamples) -> list[Reading]:
    """Read at a single pose (n = 1) what is measured without a limit, as far as it is known."""
    values = [(measure, measure.reduce(samples)) for measure in measures]
    return [
        Reading(measure.name, measure.unit, value, -np.inf, np.inf, NOT_CHECKED, "")
        for measure, value in values
        if np.isfinite(value)
    ]


def _curves(limit: Limit, samples: PoseSamples) -> Sequence[Curve]:
    if isinstance(limit, ReadLimit):
        return limit.readings(samples)
    if isinstance(limit, ShownLimit):
        return limit.curves(samples)
    # How far beyond the limit the pose is, whatever is limited.
    return (Curve(limit.wording.name, "beyond", limit.excess(samples).max(axis=1), -np.inf, 0.0),)
