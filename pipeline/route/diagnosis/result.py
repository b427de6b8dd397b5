"""What stands in the way of a route, as values: a finding per limit, remarks on the ends, what can be reached."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pipeline.arrays import BoolArray
from pipeline.limits.actuators import TRAVEL_KEY
from pipeline.limits.holding_force import FORCES_KEY
from pipeline.machine.geometry import MODES
from pipeline.route.regions.table import RegionTable


class Verdict(StrEnum):
    """What changing a limit alone does."""

    OPENS = "a route exists"
    NEVER = "no route within the bound"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Finding:
    """How far one limit has to give for a route to exist, all others as configured.

    Attributes
    ----------
    key : str
        Path of the limit in the configuration.
    configured, bound : float
        Its value there, and the value up to which milder ones were looked at.
    value : float or None
        The mildest change of those tried with which the whole search, moves followed, found a route.
    objective : float or None
        The sum of kappa (5) of that route.
    refused : float
        The largest change proven not to be enough.
    by_graph : bool
        That proof needed no more than the graph: no way over the admitted moves.
    exact : bool
        `refused` and `value` are neighbours among the values looked at: tilts of the grid, positions, 1 of kappa
        (above 1,000 a quarter of a percent), 0.1 mm of clearance or of a margin, or 1 mm of travel apart.
    verdict : Verdict
    locked_axes : tuple of str or None
        Tilt axes still locked, where the change is to unlock others.
    """

    key: str
    configured: float
    bound: float
    value: float | None
    objective: float | None
    refused: float
    by_graph: bool
    exact: bool
    verdict: Verdict
    locked_axes: tuple[str, ...] | None = None

    @property
    def sentence(self) -> str:
        """The finding in words."""
        if self.value is not None:
            least = self.exact and self.key in _DISCRETE
            less = "no milder change opens one" if least else f"{self._shown(self.refused)} is not enough"
            return f"{self._with(self.value)}: a route exists, sum of kappa {self.objective:.1f}; {less} (proven)"
        if self.verdict is Verdict.NEVER:
            how = "over all moves between regions" if self.by_graph else "by the whole search"
            return f"{self._with(self.bound)}: no route (proven {how})"
        return f"{self._with(self.bound)}: undecided; {self._shown(self.refused)} is not enough (proven)"

    def _with(self, value: float) -> str:
        if self.locked_axes is not None:
            locks = f"task.locked_axes [{', '.join(self.locked_axes)}]"
            more = f" (task.tilt_max_deg is {self.configured:g})" if value > self.configured else ""
            return f"{locks} and tilts up to {value:g} degrees{more}"
        if self.key == TRAVEL_KEY:
            return f"every {self.key} {self._shown(value)} longer at both ends"
        if self.key == FORCES_KEY:
            return f"all {self.key} {value:g} times as high"
        return f"{self.key} {self._shown(value)} instead of {self._shown(self.configured)}"

    def _shown(self, value: float) -> str:
        return f"{value:g} m" if self.key == TRAVEL_KEY else f"{value:g}"


_DISCRETE = ("task.tilt_max_deg", "route.step_budget")
"""Limits for which nothing lies between two neighbouring values: the grid has its tilts, positions are counted."""


@dataclass(frozen=True, eq=False)
class InfeasibilityReport:
    """Why there is no route.

    Attributes
    ----------
    remarks : tuple of str
        What is wrong with the ends or the grid before any limit counts, and what else is asked for.
    findings : tuple of Finding
        One per limit.
    from_start, to_goal : (n,)
        Regions that can be reached from the start, and from which the goal can be reached, over the admitted
        moves.
    """

    remarks: tuple[str, ...]
    findings: tuple[Finding, ...]
    from_start: BoolArray
    to_goal: BoolArray

    @property
    def opening(self) -> tuple[Finding, ...]:
        """The findings with which a route exists."""
        return tuple(finding for finding in self.findings if finding.verdict is Verdict.OPENS)

    def reach(self, regions: RegionTable) -> str:
        """Say how far one gets from either end, and in which working modes."""
        return (
            f"of {len(regions):,} regions {_counted(regions, self.from_start)} can be reached from the start; "
            f"the goal can be reached from {_counted(regions, self.to_goal)}"
        )


def _counted(regions: RegionTable, rows: BoolArray) -> str:
    modes = ", ".join(MODES[mode] for mode in np.unique(regions.modes[rows]))
    return f"{int(rows.sum()):,} ({modes})"
