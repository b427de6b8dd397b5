"""The end of a search by the clock: `route.time_limit_s` holds for the search as a whole, whatever solves its parts."""

import time
from dataclasses import dataclass

from pipeline.config.choices import RouteObjective
from pipeline.errors import NoSolutionError
from pipeline.progress import Monitor
from pipeline.status import Status
from pipeline.summary.objective_words import ROUTE_QUANTITIES, Quantity


class OutOfTimeError(NoSolutionError):
    """A search ended by the clock before it found a route or a proof that there is none."""


@dataclass(frozen=True)
class Deadline:
    """When a search ends: `limit_s` after it began, at `ends_s` on the monotonic clock; what it minimises, in words."""

    limit_s: float
    ends_s: float
    quantity: Quantity = ROUTE_QUANTITIES[RouteObjective.SUM]

    @classmethod
    def after(cls, limit_s: float, objective: RouteObjective = RouteObjective.SUM) -> "Deadline":
        """Start the clock."""
        return cls(limit_s, time.monotonic() + limit_s, ROUTE_QUANTITIES[objective])

    @property
    def left_s(self) -> float:
        """Seconds left, none once it has passed."""
        return max(self.ends_s - time.monotonic(), 0.0)

    @property
    def passed(self) -> bool:
        """True once the time is up."""
        return time.monotonic() >= self.ends_s

    def shown(self, monitor: Monitor) -> Monitor:
        """Let a monitor say how much time is left."""

        def progress(message: str, fraction: float | None = None) -> None:
            monitor.progress(f"{message}; at most {self.left_s:.0f} s more", fraction)

        return Monitor(progress, monitor.verbose)

    def require(self, bound: float = 0.0) -> None:
        """Go on while there is time.

        Raises
        ------
        OutOfTimeError
            When the time is up; `bound` is what a route is proven to cost at least.
        """
        if self.passed:
            raise self.error(bound)

    def error(self, bound: float = 0.0) -> OutOfTimeError:
        """Make the error that no route was found in time."""
        least = (
            f"; if there is one, its {self.quantity.name} is at least {self.quantity.shown(bound, 3)} (proven)"
            if bound > 0.0
            else ""
        )
        return OutOfTimeError(
            "route",
            f"no route was found within {self.limit_s:g} s, and none is proven to exist{least}",
            "raise route.time_limit_s, or coarsen route.grid",
            {"status": Status.TIME_LIMIT.value, "bound": bound, "time_limit_s": self.limit_s},
        )
