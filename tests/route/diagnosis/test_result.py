"""Findings in words."""

import numpy as np
import pytest

from pipeline.limits.actuators import TRAVEL_KEY
from pipeline.limits.holding_force import FORCES_KEY
from pipeline.route.diagnosis.result import Finding, InfeasibilityReport, Verdict


def finding(**changes: object) -> Finding:
    """Make a finding that opens a route, with other values where given."""
    values = {
        "key": "task.tilt_max_deg",
        "configured": 0.0,
        "bound": 45.0,
        "value": 10.0,
        "objective": 311.62,
        "refused": 5.0,
        "by_graph": True,
        "exact": True,
        "verdict": Verdict.OPENS,
    }
    return Finding(**(values | changes))


NONE = {"value": None, "objective": None, "exact": False}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {},
            "task.tilt_max_deg 10 instead of 0: a route exists, sum of kappa 311.6; no milder change opens one "
            "(proven)",
        ),
        (
            {"exact": False},
            "task.tilt_max_deg 10 instead of 0: a route exists, sum of kappa 311.6; 5 is not enough (proven)",
        ),
        (
            {"key": "route.kappa_max", "configured": 25.0, "value": 28.0, "refused": 27.0},
            "route.kappa_max 28 instead of 25: a route exists, sum of kappa 311.6; 27 is not enough (proven)",
        ),
        (
            {"locked_axes": ("rz",), "configured": 30.0},
            "task.locked_axes [rz] and tilts up to 10 degrees: a route exists, sum of kappa 311.6; no milder change "
            "opens one (proven)",
        ),
        (
            {"locked_axes": (), **NONE, "verdict": Verdict.NEVER},
            "task.locked_axes [] and tilts up to 45 degrees (task.tilt_max_deg is 0): no route (proven over all moves "
            "between regions)",
        ),
        (
            {"key": "route.kappa_max", "configured": 100.0, "bound": 1000.0, **NONE, "by_graph": False}
            | {"verdict": Verdict.NEVER},
            "route.kappa_max 1000 instead of 100: no route (proven by the whole search)",
        ),
        (
            {"key": TRAVEL_KEY, "bound": 1.0, "refused": 0.25, **NONE, "verdict": Verdict.UNDECIDED},
            "every machine.rails.travel_m 1 m longer at both ends: undecided; 0.25 m is not enough (proven)",
        ),
        ({"key": "task.avoid[1]", "removes": True}, "without task.avoid[1]: a route exists, sum of kappa 311.6"),
        (
            {"key": "task.visit", "removes": True, **NONE, "verdict": Verdict.NEVER},
            "without task.visit: no route either (proven over all moves between regions)",
        ),
        (
            {"key": "task.visit", "removes": True, **NONE, "verdict": Verdict.UNDECIDED},
            "without task.visit: undecided",
        ),
    ],
)
def test_sentences(changes: dict[str, object], words: str) -> None:
    """What to change, what it does, and what of it is proven."""
    assert finding(**changes).sentence == words


def test_reach(hand_table) -> None:
    """How many regions, and in which working modes."""
    regions = hand_table([(0.0, 1.0)] * 4, [2.0] * 4)
    regions.modes[:] = [0, 1, 0, 7]
    opens, never = finding(), finding(**NONE, verdict=Verdict.NEVER)
    found = InfeasibilityReport(
        (), (never, opens), np.array([True, True, True, False]), np.array([False, False, False, True])
    )
    assert found.opening == (opens,)
    assert found.reach(regions) == (
        "of 4 regions 3 (LLL, LLR) can be reached from the start; the goal can be reached from 1 (RRR)"
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "set task.tilt_max_deg to 10"),
        ({"locked_axes": ("rz",)}, "set task.locked_axes to [rz], task.tilt_max_deg to 10"),
        ({"key": TRAVEL_KEY, "value": 0.25}, f"make every {TRAVEL_KEY} 0.25 m longer at both ends"),
        ({"key": FORCES_KEY, "value": 1.5}, f"make all {FORCES_KEY} 1.5 times as high"),
        ({"key": "task.avoid[1]", "removes": True}, "remove task.avoid[1]"),
        (NONE, ""),
    ],
)
def test_advice(changes: dict[str, object], words: str) -> None:
    """What to do, if a route was found with it, and nothing otherwise."""
    assert finding(**changes).advice == words


def test_advice_of_a_report() -> None:
    """All changes that were tried and open a route, and no others; without any it says so."""
    none = np.zeros(1, dtype=bool)
    never, other = finding(**NONE, verdict=Verdict.NEVER), finding(key="task.avoid[0]", removes=True)

    def advice(*findings: Finding, not_tried: tuple[str, ...] = ()) -> str:
        return InfeasibilityReport((), findings, none, none, not_tried).advice

    assert advice(never, finding()) == "set task.tilt_max_deg to 10 (tried: a route exists)"
    assert advice(finding(), never, other).endswith(": set task.tilt_max_deg to 10; remove task.avoid[0]")
    assert advice(never).startswith("no single change")
    assert advice(never, not_tried=("task.avoid",)).endswith("run again to try the rest")
