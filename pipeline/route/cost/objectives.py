"""The cost that each value of `route.objective` adds up, and that of a whole route."""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import RouteConfig
from pipeline.config.choices import RouteObjective
from pipeline.machine.geometry import Machine
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.interface import MoveCost
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.metric import step_sizes
from pipeline.route.regions.table import RegionTable

COSTS: dict[RouteObjective, Callable[[RouteConfig, Machine], MoveCost]] = {
    RouteObjective.INTEGRAL: lambda options, machine: KappaIntegral(step_sizes(options)),
    RouteObjective.SUM: lambda options, machine: KappaSum(),
    RouteObjective.BOTTLENECK: lambda options, machine: KappaSum(),
    RouteObjective.TIME: lambda options, machine: ActuatorTime(machine.velocity_mps, options.x_step_m),
}
"""Makes the cost of moves. Of routes with the same largest kappa, `bottleneck` takes the one of least sum."""


def route_cost(cost: MoveCost, regions: RegionTable, rows: IntArray, x_m: FloatArray) -> float:
    """Add up the costs of the moves of a route through rows (n,) of the table, at x (n,)."""
    return float(cost.at(regions, rows[:-1], rows[1:], np.diff(x_m)).sum())
