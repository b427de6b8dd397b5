"""What each objective of stage one adds up, in words: one row per objective."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.config.choices import RouteObjective


@dataclass(frozen=True)
class Quantity:
    """The figure that says how good a route is.

    Attributes
    ----------
    name, unit : str
        Its name, and its unit where it has one.
    digits : int
        Digits shown in a short text.
    """

    name: str
    unit: str
    digits: int

    def shown(self, value: float, digits: int | None = None) -> str:
        """Format a value with its unit."""
        return f"{value:.{self.digits if digits is None else digits}f}{self.unit and ' '}{self.unit}"

    @property
    def heading(self) -> str:
        """Its name with its unit, as the heading of a column."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


ROUTE_QUANTITIES = {
    RouteObjective.INTEGRAL: Quantity("kappa integral", "", 1),
    RouteObjective.SUM: Quantity("sum of kappa", "", 1),
    RouteObjective.BOTTLENECK: Quantity("sum of kappa", "", 1),
    RouteObjective.TIME: Quantity("time of the moves", "s", 3),
}
"""`bottleneck` compares sums of kappa between routes that have the least largest kappa."""


def route_quantity(section: Mapping[str, object]) -> Quantity:
    """Give the quantity of a route's section of a summary; those without an objective are of the sum (5)."""
    return ROUTE_QUANTITIES[RouteObjective(str(section.get("objective_kind", RouteObjective.SUM)))]
