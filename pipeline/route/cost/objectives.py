"""The cost that each value of `route.objective` adds up, and that of a whole route."""

from collections.abc import Callable

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.config.choices import RouteObjective
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.interface import MoveCost
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.metric import step_sizes
from pipeline.route.regions.table import RegionTable


def _actuator_time(config: Config) -> ActuatorTime:
    limits = config.machine.limits
    carts, telescopes = limits.carts.velocity_mps, limits.telescopes.velocity_mps
    return ActuatorTime(np.array([carts] * 3 + [telescopes] * 2), config.route.x_step_m)


COSTS: dict[RouteObjective, Callable[[Config], MoveCost]] = {
    RouteObjective.INTEGRAL: lambda config: KappaIntegral(step_sizes(config.route)),
    RouteObjective.SUM: lambda config: KappaSum(),
    RouteObjective.BOTTLENECK: lambda config: KappaSum(),
    RouteObjective.TIME: _actuator_time,
}
"""Makes the cost of moves. Of routes with the same largest kappa, `bottleneck` takes the one of least sum."""


def route_cost(cost: MoveCost, regions: RegionTable, rows: IntArray, x_m: FloatArray) -> float:
    """Add up the costs of the moves of a route through rows (n,) of the table, at x (n,)."""
    return float(cost.at(regions, rows[:-1], rows[1:], np.diff(x_m)).sum())
