"""The rules of a route and nothing else: an independent check of what a solver returned.

It knows (8)-(17), (38), the windows of x, tilt limits, visits, budgets and boxes to avoid; not the graph, the core or
the program.
"""

import itertools

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.route.regions.boxes import grown_boxes
from pipeline.route.regions.table import RegionTable

_ARMS = ((4, 1), (2, 2), (1, 3))
"""Bit in the number of a working mode, and number, of each arm."""

_PARTS = np.linspace(0.0, 1.0, 41)[:, None, None]
"""Where along a move it is checked against the boxes to avoid."""


def rule_violations(
    regions: RegionTable, rows: IntArray, x_m: FloatArray, steps: FloatArray, step_budget: int, tolerance: float = 1e-7
) -> list[str]:
    """Name every rule of the paper that regions (n,) with positions x (n,) break; none for a valid route.

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
    modes, gates = regions.modes[rows], regions.gates[rows]
    for bit, arm in _ARMS:
        changed = (modes[1:] & bit) != (modes[:-1] & bit)
        found += [f"(38): arm {arm} changes after step {i}" for i in _where(changed & (gates[:-1] != arm))]
    opposite = regions.det_sign[rows[1:]] != regions.det_sign[rows[:-1]]
    return found + [f"det H changes sign after step {i}" for i in _where(opposite)]


def task_violations(config: Config, regions: RegionTable, rows: IntArray, x_m: FloatArray) -> list[str]:
    """Name everything else the task asks for that regions (n,) with positions x (n,) do not fulfil."""
    task = config.task
    found = _tilt_violations(config, np.abs(regions.controlled[rows, 3:]))
    stops = regions.visits[rows]
    made = 0
    for stop in stops[stops > 0].tolist():
        made += stop == made + 1
    found += [f"task.visit[{k}] is not visited in its turn" for k in range(made, len(task.visit))]
    positions = np.column_stack([x_m, regions.controlled[rows, 1:]])
    moved = np.abs(np.diff(positions, axis=0))
    modes = regions.modes[rows]
    for key, used in (
        ("mode_changes", sum(bin(a ^ b).count("1") for a, b in itertools.pairwise(modes.tolist()))),
        ("tilt_deg", float(np.rad2deg(moved[:, 3:].sum()))),
        ("travel_m", float(moved[:, :3].sum())),
    ):
        limit = getattr(task.budget, key)
        if limit is not None and used > limit + 1e-5:
            found.append(f"task.budget.{key}: {used:g} used, {limit:g} allowed")
    line = positions[:-1] + _PARTS * np.diff(positions, axis=0)
    for k, box in enumerate(grown_boxes(config)):
        inside = np.asarray((box.depth_m(line) > 1e-6).any(axis=0))
        found += [f"task.avoid[{k}] is entered after step {i}" for i in _where(inside)]
    return found


def _tilt_violations(config: Config, tilt_rad: FloatArray) -> list[str]:
    """Name the steps of tilts |rx|, |rz| (n, 2) beyond the limit, or about a locked axis."""
    found, task = [], config.task
    for axis, tilts in zip(("rx", "rz"), tilt_rad.T, strict=True):
        locked = axis in task.locked_axes
        key, limit = ("task.locked_axes", 0.0) if locked else ("task.tilt_max_deg", np.deg2rad(task.tilt_max_deg))
        found += [f"{key}: {axis} of step {i} is beyond it" for i in _where(tilts > limit + 1e-7)]
    return found


def _where(condition: BoolArray) -> list[int]:
    return np.flatnonzero(condition).tolist()
