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
        """Maximise the dual: single pieces and convex combinations of two, see `_dual`. Shape (m,).

        The priced travel is that of cart 1, which is dx and what the platform needs of it: no move of cart 1 costs
        less than its price then.
        """
        own = self.offset_m(regions)
        value = self._dual(regions, source, target, price)[0] - price * (own[target] - own[source])
        return np.asarray(np.maximum(value, 0.0))

    def wait(self, regions: RegionTable) -> FloatArray:
        """Give the seconds per metre of the slowest cart. Shape (n,)."""
        return np.full(len(regions), 1.0 / self.velocity_mps[:3].min())

    def best_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give where two pieces meet, or the largest move. Shape (m,)."""
        return self._dual(regions, source, target, price)[1]

    def _dual(
        self, regions: RegionTable, source: IntArray, target: IntArray, price: float
    ) -> tuple[FloatArray, FloatArray]:
        """Minimise cost - p dx over |dx| <= Delta X: values, and the dx that attain them. Shapes (m,).

        The largest of pieces a + s dx is least where two pieces with slopes on either side of p meet, at which it is
        their convex combination of slope p; or at an end of the largest move, a - |s - p| Delta X for some piece.
        """
        best, travel = np.full(len(source), -np.inf), np.zeros(len(source))
        pieces = self._pieces(regions, source, target)
        for slope, value in pieces:
            at_end = value - abs(slope - price) * self.x_step_m
            _raise(best, travel, at_end, np.broadcast_to(np.copysign(self.x_step_m, price - slope), travel.shape))
        for low, low_value in pieces:
            for high, high_value in pieces:
                if low <= price <= high and low < high:
                    share = (price - low) / (high - low)
                    value = share * high_value + (1.0 - share) * low_value
                    _raise(best, travel, value, (low_value - high_value) / (high - low))
        return best, travel

    def _pieces(self, regions: RegionTable, source: IntArray, target: IntArray) -> list[tuple[float, FloatArray]]:
        """List the pieces a + s dx of the cost, those of one slope s as one: s, and a (m,)."""
        carts, rest = self._parts(regions, source, target)
        pieces = [(0.0, rest)]
        for velocity in np.unique(self.velocity_mps[:3]).tolist():
            alike = carts[self.velocity_mps[:3] == velocity]
            pieces += [(1.0 / velocity, alike.max(axis=0)), (-1.0 / velocity, (-alike).max(axis=0))]
        return pieces

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


def _raise(best: FloatArray, travel: FloatArray, value: FloatArray, at: FloatArray) -> None:
    """Take over values (m,) where they are larger, and the travels at which they are attained."""
    better = np.flatnonzero(value > best)
    best[better], travel[better] = value[better], at[better]
