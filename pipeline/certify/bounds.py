"""What a certificate proves for every s: bounds of every limit, and how far both ends are from the task's."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.chain import Chain
from pipeline.limits.interface.limit import ProvenLimit
from pipeline.limits.kappa import DET_SIGN, KAPPA, KappaCap


@dataclass(frozen=True, eq=False)
class Ranges:
    """Bounds of named quantities.

    Attributes
    ----------
    subjects : tuple of str
        Their m names.
    values : (m, 2)
        Bounds from below and above, infinite on a side without one.
    """

    subjects: tuple[str, ...]
    values: FloatArray


@dataclass(frozen=True, eq=False)
class Bounds:
    """What is proven for every s.

    Attributes
    ----------
    ranges : mapping
        Bounds by their keys in certificate.json, in the units of the keys.
    kappa_s : float
        The middle of the box with the largest bound of kappa.
    start_miss, goal_miss : float
        How far the ends are from the task's poses at most, in metres or radians.
    """

    ranges: Mapping[str, Ranges]
    kappa_s: float
    start_miss: float
    goal_miss: float

    @property
    def kappa(self) -> float:
        """Upper bound of the condition number."""
        return float(self.ranges[KAPPA.name].values[0, 1])

    @property
    def det_sign(self) -> int:
        """Sign of det H along the whole path; 0 if it is not proven to have one."""
        least, largest = self.ranges[DET_SIGN.name].values[0]
        return int(least) if least == largest else 0

    @property
    def pairs(self) -> tuple[str, ...]:
        """The pairs of axes whose distances are bounded; none if none are."""
        return self.ranges["distance_m"].subjects if "distance_m" in self.ranges else ()

    @property
    def distances_m(self) -> FloatArray:
        """Lower bounds of the distances of all pairs, shape (pairs,)."""
        return self.ranges["distance_m"].values[:, 0] if self.pairs else np.empty(0)

    @property
    def actuators_m(self) -> FloatArray:
        """Bounds of carts and telescopes from below and above, shape (5, 2)."""
        return self.ranges["actuators_m"].values

    @property
    def tilt_deg(self) -> FloatArray:
        """Upper bounds of |rx| and |rz|, shape (2,)."""
        return self.ranges["tilt_deg"].values[:, 1]


def combine_bounds(limits: Sequence[ProvenLimit], chain: Chain, misses: tuple[float, float]) -> Bounds:
    """Combine the bounds over all boxes of a chain: the least of the lower ones, the largest of the upper ones."""
    found: dict[str, list[tuple[str, FloatArray]]] = {}
    kappa_s = np.nan
    for limit, boxes in zip(limits, zip(*chain.bounds, strict=True), strict=True):
        stacked = np.stack(boxes)
        combined = np.stack([stacked[..., 0].min(axis=0), stacked[..., 1].max(axis=0)], axis=1)
        for quantity, bounds in zip(limit.quantities, combined, strict=True):
            found.setdefault(quantity.key.name, []).append((quantity.subject, bounds))
        if isinstance(limit, KappaCap):
            worst = chain.inclusions[int(stacked[:, 0, 1].argmax())].box
            kappa_s = (worst.first + worst.last) / 2.0
    ranges = {
        key: Ranges(tuple(subject for subject, _ in rows), np.array([bounds for _, bounds in rows]))
        for key, rows in found.items()
    }
    return Bounds(ranges, kappa_s, *misses)
