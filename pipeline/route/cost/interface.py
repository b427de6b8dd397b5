"""What a move of a route costs: a convex function of its travel along X, which the route is free to choose.

Moves are given by their ends, rows of a region table; the travel is that of the TCP, dx. Everything that depends on
the objective of stage one is asked of its cost: lower bounds by shortest paths, where the best x is left open; the
tangents of which the mixed-integer program is made; and the value of a route.
"""

from typing import Protocol

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.regions.table import RegionTable


class MoveCost(Protocol):
    """The cost of moves between regions; waiting in a region is a move, too, and free at the goal."""

    @property
    def counts_x(self) -> bool:
        """Whether the cost depends on dx."""

    def first_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give the dx at which programs start with tangents of moves (m,), `least` at the price among them. (k, m)."""

    def at(self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray) -> FloatArray:
        """Compute the cost of moves between rows (m,) that travel dx (m,). Shape (m,)."""

    def tangent(
        self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Compute a tangent constant + slope dx, never above the cost, that touches it at dx (m,). Shapes (m,)."""

    def least(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Bound from below what moves (m,) cost less `price` times their priced travel, whatever their dx. Shape (m,).

        The bound is never negative for prices up to the highest one in either direction.
        """

    def wait(self, regions: RegionTable) -> FloatArray:
        """Give what a metre along X costs in each region by waits alone, (n,); a wait costs in proportion to its dx."""

    def best_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Compute the dx of moves (m,) at which `least` is attained; of none beyond a largest move. Shape (m,)."""

    def most(self, regions: RegionTable) -> float:
        """Bound the cost of every move from above."""

    def offset_m(self, regions: RegionTable) -> FloatArray:
        """Give what is added to x for the position whose travel is priced, (n,)."""

    def priced_travel(self, regions: RegionTable) -> float:
        """Compute the priced travel from start to goal in total (m), the same for every route."""

    def highest_price(self, regions: RegionTable) -> float:
        """Bound the price of a metre of priced travel; zero when the cost does not depend on dx."""
