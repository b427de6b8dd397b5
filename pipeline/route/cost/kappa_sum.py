"""The paper's cost (5) with (25)-(26): a move costs kappa of the region it leaves, and nothing at the goal."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.regions.table import RegionTable


def region_costs(regions: RegionTable) -> FloatArray:
    """Compute what a step in each region costs, gamma kappa of (25)-(26): its kappa, zero at the goal. Shape (n,)."""
    costs = regions.kappa.copy()
    costs[regions.goal] = 0.0
    return costs


@dataclass(frozen=True)
class KappaSum:
    """The sum of kappa over all regions but the goal, (5); x costs nothing."""

    counts_x: bool = False

    def first_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """One tangent is the whole cost. Shape (1, m)."""
        return np.zeros((1, len(source)))

    def at(self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray) -> FloatArray:
        """Give kappa of the regions that are left, zero at the goal. Shape (m,)."""
        return region_costs(regions)[source]

    def tangent(
        self, regions: RegionTable, source: IntArray, target: IntArray, dx_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Give the cost itself, and slopes of zero. Shapes (m,)."""
        costs = self.at(regions, source, target, dx_m)
        return costs, np.zeros_like(costs)

    def least(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give the cost itself. Shape (m,)."""
        return region_costs(regions)[source]

    def wait(self, regions: RegionTable) -> FloatArray:
        """Give nothing: a wait costs by the step. Shape (n,)."""
        return np.zeros(len(regions))

    def best_travel(self, regions: RegionTable, source: IntArray, target: IntArray, price: float) -> FloatArray:
        """Give none: any is as good. Shape (m,)."""
        return np.zeros(len(source))

    def most(self, regions: RegionTable) -> float:
        """Give the largest kappa."""
        return float(regions.kappa.max())

    def offset_m(self, regions: RegionTable) -> FloatArray:
        """Give none: no travel has a price. Shape (n,)."""
        return np.zeros(len(regions))

    def priced_travel(self, regions: RegionTable) -> float:
        """No travel has a price."""
        return 0.0

    def highest_price(self, regions: RegionTable) -> float:
        """No travel has a price."""
        return 0.0
