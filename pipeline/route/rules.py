"""The rules of a route, and nothing else: an independent look at what a solver returned.

It knows (8)-(17), (38), the windows of x and the cost (5); not the graph, the core or the program.
"""

import numpy as np

from pipeline.machine.geometry import BoolArray, FloatArray, IntArray
from pipeline.route.regions import RegionTable

_ARMS = ((4, 1), (2, 2), (1, 3))
"""Bit in the number of a working mode, and number, of each arm."""


def rule_violations(
    regions: RegionTable, rows: IntArray, x_m: FloatArray, steps: FloatArray, step_budget: int, tolerance: float = 1e-7
) -> list[str]:
    """Name every rule that a sequence of regions (n,) with positions x (n,) breaks; an empty list is a valid route.

    `steps` (5,) are the largest moves of x, y, z, rx, rz.
    """
    found = []
    if rows[0] != regions.start:
        found.append("(8)-(9): it does not begin at the start")
    if rows[-1] != regions.goal:
        found.append("(10)-(11): it does not end at the goal")
    if len(rows) > step_budget:
        found.append(f"it has {len(rows)} positions, more than the step budget")
    low, high = regions.x_window_m[rows].T
    outside = (x_m < low - tolerance) | (x_m > high + tolerance)
    found += [f"(18): x of step {i} is outside its window" for i in _where(outside)]
    positions = np.column_stack([x_m, regions.controlled[rows, 1:]])
    too_far = np.abs(np.diff(positions, axis=0)) > steps + tolerance
    for axis in range(5):
        found += [f"({13 + axis}): the move after step {i} is too long" for i in _where(too_far[:, axis])]
    modes, gates = regions.mode[rows], regions.gate[rows]
    for bit, arm in _ARMS:
        changed = (modes[1:] & bit) != (modes[:-1] & bit)
        found += [f"(38): arm {arm} changes after step {i}" for i in _where(changed & (gates[:-1] != arm))]
    opposite = regions.det_sign[rows[1:]] != regions.det_sign[rows[:-1]]
    return found + [f"det H changes sign after step {i}" for i in _where(opposite)]


def route_cost(regions: RegionTable, rows: IntArray) -> float:
    """Add up kappa of every region but the goal, (5) with (25)-(26)."""
    return float(regions.kappa[rows[rows != regions.goal]].sum())


def _where(condition: BoolArray) -> list[int]:
    return np.flatnonzero(condition).tolist()
