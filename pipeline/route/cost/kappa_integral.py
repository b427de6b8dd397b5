"""The integral of kappa along the route, the quantity that stage two minimises.

A move of length l = sqrt(L^2 + (dx / Delta X)^2), where L is the length of its (dy, dz, drx, drz) in grid steps,
costs (kappa_a + kappa_b) / 2 times l: the trapezoidal rule between its ends. A wait is a move along X alone.
"""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.regions.table import RegionTable


@dataclass(frozen=True, eq=False)
class KappaIntegral:
    """The trapezoidal integral of kappa over the length of the moves.

    Attributes
    ----------
    steps : (5,)
        Largest moves per step of x, y, z (metres), rx, rz (radians), (13)-(17): the units of length.
    """

    steps: FloatArray
    counts_x: bool = True

    def first_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """None, half and all of the largest move, both ways, and the best one at the price. Shape (6, m)."""
        fixed = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]) * self.steps[0]
        return np.vstack(
            [np.repeat(fixed[:, None], len(source), axis=1), self.best_travel(regions, source, target, price)]
        )

    def at(self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray) -> FloatArray:
        """Compute the mean kappa of the ends times the length of moves (m,). Shape (m,)."""
        length = np.hypot(self._length(regions, source, target), self._in_steps(dx_m))
        return np.asarray(_mean_kappa(regions, source, target) * length)

    def tangent(
        self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Differentiate: kappa L^2 / l and kappa dx / (Delta X^2 l); flat for a wait without travel. Shapes (m,)."""
        kappa, L, d = _mean_kappa(regions, source, target), self._length(regions, source, target), self._in_steps(dx_m)
        length = np.hypot(L, d)
        # At length zero the cost has a kink, and the flat tangent is one of many.
        per_length = kappa / np.where(length > 0.0, length, 1.0)
        return per_length * L**2, per_length * d / self.steps[0]

    def least(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Minimise kappa sqrt(L^2 + d^2) - p d over 0 <= d <= 1, where p is the price of a step. Shape (m,).

        The minimum is at d = p L / sqrt(kappa^2 - p^2), or at d = 1 where that is beyond it.
        """
        kappa, L = _mean_kappa(regions, source, target), self._length(regions, source, target)
        if price == 0.0:
            return np.asarray(kappa * L)
        p = abs(price) * self.steps[0]
        d = _best_part(kappa, L, p)
        return np.asarray(np.maximum(kappa * np.hypot(L, d) - p * d, 0.0))

    def wait(self, regions: RegionTable) -> FloatArray:
        """Give kappa per grid step. Shape (n,)."""
        return np.asarray(regions.kappa / self.steps[0])

    def best_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give that d in metres, in the direction of the price. Shape (m,)."""
        kappa, L = _mean_kappa(regions, source, target), self._length(regions, source, target)
        return math.copysign(self.steps[0], price) * _best_part(kappa, L, abs(price) * self.steps[0])

    def most(self, regions: RegionTable) -> float:
        """Give the largest kappa times the length of a move that is one step long in all five coordinates."""
        return float(regions.kappa.max() * np.sqrt(5.0))

    def offset_m(self, regions: RegionTable) -> FloatArray:
        """Give none: the travel is that of the TCP. Shape (n,)."""
        return np.zeros(len(regions))

    def priced_travel(self, regions: RegionTable) -> float:
        """Give the travel along X from start to goal."""
        return float(regions.controlled[regions.goal, 0] - regions.controlled[regions.start, 0])

    def highest_price(self, regions: RegionTable) -> float:
        """Give the cost of a metre along X in the region of least kappa."""
        return float(regions.kappa.min() / self.steps[0])

    def _in_steps(self, dx_m: FloatArray) -> FloatArray:
        return np.asarray(dx_m / self.steps[0])

    def _length(self, regions: RegionTable, source: IntArray, target: IntArray) -> FloatArray:
        """Compute the length of moves (m,) without x, in steps. Shape (m,)."""
        squared = np.zeros(len(source))
        for axis in range(1, 5):
            column = regions.controlled[:, axis] / self.steps[axis]
            squared += (column[target] - column[source]) ** 2
        return np.sqrt(squared)


def _best_part(kappa: FloatArray, L: FloatArray, p: float) -> FloatArray:
    """Minimise kappa sqrt(L^2 + d^2) - p d over 0 <= d <= 1; none where it is all the same. Shape (m,)."""
    below = np.sqrt(np.maximum((kappa - p) * (kappa + p), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(p * L > 0.0, np.minimum(p * L / below, 1.0), 0.0))


def _mean_kappa(regions: RegionTable, source: IntArray, target: IntArray) -> FloatArray:
    return np.asarray((regions.kappa[source] + regions.kappa[target]) / 2.0)
