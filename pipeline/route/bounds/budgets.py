"""Budgets: what a route may use in total, added up over its moves.

Each limits a sum of absolute changes from step to step: of working mode (per arm), of rx and rz, of x, y and z.
What a move between two regions uses is known except for x, which is an unknown of the programs.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.route.cost.interface import MoveCost
from pipeline.route.regions.table import RegionTable


@dataclass(frozen=True, eq=False)
class Budget:
    """One budget.

    Attributes
    ----------
    key : str
        Its key in `task.budget`.
    limit : float
        Largest sum of changes; changes of working mode, radians or metres.
    axes : tuple of int
        Which of y, z, rx, rz (1 to 4) count.
    modes, travels : bool
        Whether changes of working mode, and of x, count.
    in_degrees : bool
        Whether a person reads and writes it in degrees.
    """

    key: str
    limit: float
    axes: tuple[int, ...]
    modes: bool = False
    travels: bool = False
    in_degrees: bool = False

    @property
    def coordinates(self) -> tuple[int, ...]:
        """The coordinates that count: x, y, z, rx, rz are 0 to 4, the working modes of arms 1 to 3 are 5 to 7."""
        return (0,) * self.travels + self.axes + (5, 6, 7) * self.modes

    def used(self, regions: RegionTable, source: IntArray, target: IntArray) -> FloatArray:
        """Compute how much moves between rows (m,) use, without x. Shape (m,)."""
        used = np.zeros(len(source))
        for axis in self.axes:
            column = regions.controlled[:, axis]
            used += np.abs(column[target] - column[source])
        if self.modes:
            used += np.bitwise_count(regions.modes[source] ^ regions.modes[target])
        return used

    def shown(self, regions: RegionTable, used: float) -> str:
        """Format a least use in the unit of the key, with the least travel along X added, rounded down: a bound."""
        total = used + self.limit - self.left(regions)
        return f"{np.floor((np.rad2deg(total) if self.in_degrees else total) * 1e4 + 1e-5) / 1e4:g}"

    def left(self, regions: RegionTable) -> float:
        """Compute what is left after the travel from the start's x to the goal's, which every route needs."""
        x = regions.x_window_m[:, 0]
        return self.limit - (abs(float(x[regions.goal] - x[regions.start])) if self.travels else 0.0)


def task_budgets(config: Config) -> tuple[Budget, ...]:
    """Read `task.budget`."""
    limits = config.task.budget
    found = []
    if limits.mode_changes is not None:
        found.append(Budget("mode_changes", float(limits.mode_changes), (), modes=True))
    if limits.tilt_deg is not None:
        found.append(Budget("tilt_deg", float(np.deg2rad(limits.tilt_deg)), (3, 4), in_degrees=True))
    if limits.travel_m is not None:
        found.append(Budget("travel_m", limits.travel_m, (1, 2), travels=True))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Prices:
    """Budgets with a price each, and a price of travel: Lagrange multipliers, which make their use a part of the cost.

    A route of cost c that keeps all budgets has a priced cost of at most c + `credit`, so that lower bounds on
    priced costs are lower bounds on costs. Any price is valid, that of travel up to `MoveCost.highest_price`; good
    ones make the bounds sharp.
    """

    budgets: tuple[Budget, ...] = ()
    prices: tuple[float, ...] = ()
    travel: float = 0.0

    def cost(self, cost: MoveCost, regions: RegionTable, source: IntArray, target: IntArray) -> FloatArray:
        """Bound from below what moves between rows (m,) cost at these prices, their dx left open. Shape (m,)."""
        total = cost.least(regions, source, target, self.travel)
        return total + self.penalty(regions, source, target) if any(self.prices) else total

    def penalty(self, regions: RegionTable, source: IntArray, target: IntArray) -> FloatArray:
        """Compute what moves between rows (m,) cost on top of kappa. Shape (m,)."""
        total = np.zeros(len(source))
        for budget, price in zip(self.budgets, self.prices, strict=True):
            if price > 0.0:
                total += price * budget.used(regions, source, target)
        return total

    def credit(self, cost: MoveCost, regions: RegionTable) -> float:
        """Compute the price of all budgets used up, less that of the travel every route makes."""
        used_up = sum(price * budget.left(regions) for budget, price in zip(self.budgets, self.prices, strict=True))
        return used_up - self.travel * cost.priced_travel(regions)

    @property
    def charged(self) -> bool:
        """True when anything has a price."""
        return any(price != 0.0 for price in (*self.prices, self.travel))


FREE = Prices()
"""No budgets."""
