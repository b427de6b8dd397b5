"""What stands in the way of a route, as values: a finding per limit, remarks on the ends, what can be reached."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.limits.actuators import TRAVEL_KEY
from pipeline.limits.holding_force import FORCES_KEY
from pipeline.machine.geometry import MODES
from pipeline.route.diagnosis.threshold import FeasibilityThreshold
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
    removes : bool
        That the change is to remove it.
    obstruction : str
        How it would be in the way of the route without it.
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
    removes: bool = False
    obstruction: str = ""

    @property
    def advice(self) -> str:
        """What to do, where a route was found with it; a part of a sentence."""
        if self.value is None:
            return ""
        if self.removes:
            return f"remove {self.key}"
        if self.locked_axes is not None:
            return f"set task.locked_axes to [{', '.join(self.locked_axes)}], task.tilt_max_deg to {self.value:g}"
        if self.key == TRAVEL_KEY:
            return f"make every {self.key} {self._shown(self.value)} longer at both ends"
        if self.key == FORCES_KEY:
            return f"make all {self.key} {self.value:g} times as high"
        return f"set {self.key} to {self.value:g}"

    @property
    def sentence(self) -> str:
        """The finding in words."""
        if self.removes:
            return f"without {self.key}: {self._without}"
        if self.value is not None:
            least = self.exact and self.key in _DISCRETE
            less = "no milder change opens one" if least else f"{self._shown(self.refused)} is not enough"
            return f"{self._with(self.value)}: a route exists, sum of kappa {self.objective:.1f}; {less} (proven)"
        if self.verdict is Verdict.NEVER:
            return f"{self._with(self.bound)}: no route (proven {self._how})"
        return f"{self._with(self.bound)}: undecided; {self._shown(self.refused)} is not enough (proven)"

    @property
    def _without(self) -> str:
        if self.value is not None:
            way = f"; on it, {self.obstruction}" if self.obstruction else ""
            return f"a route exists, sum of kappa {self.objective:.1f}{way}"
        if self.verdict is Verdict.NEVER:
            return f"no route either (proven {self._how})"
        return "undecided"

    @property
    def _how(self) -> str:
        return "over all moves between regions" if self.by_graph else "by the whole search"

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


_DISCRETE = ("task.tilt_max_deg", "route.step_budget", "task.budget.mode_changes")
"""Limits for which nothing lies between two neighbouring values: the grid has its tilts, the others are counted."""


def make_finding(
    key: str,
    configured: float,
    levels: FloatArray,
    threshold: FeasibilityThreshold,
    *,
    locked_axes: tuple[str, ...] | None = None,
    removes: bool = False,
) -> Finding:
    """State where in a list of values (n,) of a limit routes begin to exist; a Finding has the other parameters."""
    none = Verdict.NEVER if threshold.refused == len(levels) - 1 else Verdict.UNDECIDED
    return Finding(
        key=key,
        configured=configured,
        bound=float(levels[-1]),
        value=None if threshold.opened is None else float(levels[threshold.opened]),
        objective=threshold.objective,
        refused=float(levels[threshold.refused]),
        by_graph=threshold.by_graph,
        exact=threshold.opened == threshold.refused + 1,
        verdict=none if threshold.opened is None else Verdict.OPENS,
        locked_axes=locked_axes,
        removes=removes,
        obstruction=threshold.obstruction,
    )


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
    not_tried : tuple of str
        Keys of what was left out because of an interrupt.
    """

    remarks: tuple[str, ...]
    findings: tuple[Finding, ...]
    from_start: BoolArray
    to_goal: BoolArray
    not_tried: tuple[str, ...] = ()

    @property
    def advice(self) -> str:
        """What to change: what was tried and opens a route, never anything else."""
        if self.opening:
            changes = [finding.advice for finding in self.opening]
            one = "one of these changes; each was tried, and a route exists: " if len(changes) > 1 else ""
            return one + "; ".join(changes) + ("" if one else " (tried: a route exists)")
        if self.not_tried:
            return "nothing of what was tried opens a route; run again to try the rest"
        return "no single change of those listed below opens a route: let two of them give, or refine the grid"

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
