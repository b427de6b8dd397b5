"""The cost of a route, (5) with (25)-(26): the sum of kappa over all regions but the goal."""

from pipeline.arrays import FloatArray, IntArray
from pipeline.route.regions.table import RegionTable


def region_costs(regions: RegionTable) -> FloatArray:
    """Compute what a step in each region costs, gamma kappa of (25)-(26): its kappa, zero at the goal. Shape (n,)."""
    costs = regions.kappa.copy()
    costs[regions.goal] = 0.0
    return costs


def route_cost(regions: RegionTable, rows: IntArray) -> float:
    """Add up the costs of a route through regions (k,) of the table; the goal may be waited in for nothing."""
    return float(region_costs(regions)[rows[rows != regions.goal]].sum())
