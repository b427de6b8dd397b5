"""The least time of a move at the velocity limits: the largest |dq_i| / v_i of the five actuators.

Carts move by what the platform needs of them and by dx; telescopes by what the platform needs. The cost is the
largest of seven pieces linear in dx: one for the telescopes, two for each cart.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.regions.table import RegionTable


@dataclass(frozen=True, eq=False)
class ActuatorTime:
    """Seconds that moves take at least, each alone, at the velocity limits.

    Attributes
    ----------
    velocity_mps : (5,)
        Velocity limits of the actuators c1, c2, c3, l2b, l3b.
    x_step_m : float
        Largest move along X per step, (13).
    """

    velocity_mps: FloatArray
    x_step_m: float
    counts_x: bool = True

    def first_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Beyond all else, which are the outer pieces, and both sides of where each cart stands still. Shape (8, m)."""
        still = -(self._parts(regions, source, target)[0] * self._carts)
        near = 1e-3 * self.x_step_m
        far = np.abs(still).max(axis=0) + self.x_step_m
        return np.vstack([-far, far, *(still - near), *(still + near)])

    def at(self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray) -> FloatArray:
        """Compute the largest |dq_i| / v_i of moves (m,). Shape (m,)."""
        carts, rest = self._parts(regions, source, target)
        return np.asarray(np.maximum(np.abs(carts + np.asarray(dx_m) / self._carts).max(axis=0), rest))

    def tangent(
        self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Give the piece that is largest at dx. Shapes (m,)."""
        carts, rest = self._parts(regions, source, target)
        there = carts + np.asarray(dx_m) / self._carts
        column = np.arange(len(source))
        largest = np.abs(there).argmax(axis=0)
        sign = np.sign(there[largest, column])
        moved = np.abs(there[largest, column]) > rest
        slope = np.where(moved, sign / self.velocity_mps[largest], 0.0)
        return np.where(moved, sign * carts[largest, column], rest), slope

    def least(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Maximise the dual: convex combinations of two pieces whose slopes add up to the price. Shape (m,).

        The priced travel is that of cart 1, which is dx and what the platform needs of it: no move of cart 1 costs
        less than its price then.
        """
        return self._dual(regions, source, target, price)[0]

    def wait(self, regions: RegionTable) -> FloatArray:
        """Give the seconds per metre of the slowest cart. Shape (n,)."""
        return np.full(len(regions), 1.0 / self.velocity_mps[:3].min())

    def best_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give where the two pieces meet. Shape (m,)."""
        return self._dual(regions, source, target, price)[1]

    def _dual(
        self, regions: RegionTable, source: IntArray, target: IntArray, price: float
    ) -> tuple[FloatArray, FloatArray]:
        """Maximise the dual: its values and the travels of cart 1 that attain them. Shapes (m,)."""
        carts, rest = self._parts(regions, source, target)
        # Measured from cart 1: its piece is dx' / v_1, where dx' is its travel.
        carts = carts - carts[0] * (self.velocity_mps[0] / self.velocity_mps[:3])[:, None]
        up, down = 1.0 / self.velocity_mps[:3], -1.0 / self.velocity_mps[:3]
        lines = [(carts[i], up[i]) for i in range(3)] + [(-carts[i], down[i]) for i in range(3)] + [(rest, 0.0)]
        best, travel = np.zeros(len(source)), np.zeros(len(source))
        for low_value, low in lines:
            for high_value, high in lines:
                if low <= price <= high and low < high:
                    share = (price - low) / (high - low)
                    value = share * high_value + (1.0 - share) * low_value
                    better = np.flatnonzero(value > best)
                    best[better] = value[better]
                    travel[better] = (low_value - high_value)[better] / (high - low)
        return best, travel

    def most(self, regions: RegionTable) -> float:
        """Give the time from one end of everything in the table to the other, and the largest move along X."""
        own = np.column_stack([regions.q_m[:, :3] - regions.controlled[:, :1], regions.q_m[:, 3:]])
        reach = np.ptp(own, axis=0) + np.append(np.full(3, self.x_step_m), np.zeros(2))
        return float((reach / self.velocity_mps).max())

    def offset_m(self, regions: RegionTable) -> FloatArray:
        """Give where cart 1 is for x = 0. Shape (n,)."""
        return np.asarray(regions.q_m[:, 0] - regions.controlled[:, 0])

    def priced_travel(self, regions: RegionTable) -> float:
        """Give the travel of cart 1 from start to goal."""
        return float(regions.q_m[regions.goal, 0] - regions.q_m[regions.start, 0])

    def highest_price(self, regions: RegionTable) -> float:
        """Give the seconds per metre of the fastest cart."""
        return float(1.0 / self.velocity_mps[:3].max())

    @property
    def _carts(self) -> FloatArray:
        return self.velocity_mps[:3, None]

    def _parts(self, regions: RegionTable, source: IntArray, target: IntArray) -> tuple[FloatArray, FloatArray]:
        """Compute dq_i / v_i of the carts (3, m) for dx = 0, and the largest |dq_i| / v_i of the telescopes (m,)."""
        carts = (regions.q_m[:, :3] - regions.controlled[:, :1]).T / self._carts
        telescopes = regions.q_m[:, 3:].T / self.velocity_mps[3:, None]
        return carts[:, target] - carts[:, source], np.abs(telescopes[:, target] - telescopes[:, source]).max(axis=0)
