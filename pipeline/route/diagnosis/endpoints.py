"""Start and goal held against the grid: what bars the way before any search begins."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.limits import admits, pose_limits
from pipeline.limits.actuator_margins import within_margins
from pipeline.limits.actuators import TRAVEL_REFUSED, x_windows
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves
from pipeline.route.regions.grid import grid_axes, grid_points
from pipeline.route.regions.table import RegionTable

_ROUNDING = 1e-9


def end_remarks(config: Config, machine: Machine, regions: RegionTable, moves: Moves) -> list[str]:
    """Say what is wrong with the tilt grid, and with a start or goal that no move leaves or reaches."""
    remarks = _tilt_remarks(config)
    for name, row, joined in (("start", regions.start, moves.source), ("goal", regions.goal, moves.target)):
        if not (joined == row).any():
            off = _off_grid(config, name, regions.controlled[row])
            remarks += off or [_isolated(config, machine, name, regions.controlled[row], int(regions.modes[row]))]
    return remarks


def _tilt_remarks(config: Config) -> list[str]:
    task, grid = config.task, config.route.grid
    free = {axis: getattr(grid, f"{axis}_step_deg") for axis in ("rx", "rz") if axis not in task.locked_axes}
    if not free:
        return ["task.locked_axes holds both tilts: the platform cannot tilt at all"]
    flat = {axis: step for axis, step in free.items() if task.tilt_max_deg < step * (1.0 - _ROUNDING)}
    if not flat:
        return []
    steps = " and ".join(f"route.grid.{axis}_step_deg ({step:g})" for axis, step in flat.items())
    return [
        f"the grid of {' and '.join(flat)} has 0 degrees alone: tilts are multiples of {steps}, and "
        f"task.tilt_max_deg is {task.tilt_max_deg:g}"
    ]


def _off_grid(config: Config, name: str, controlled: FloatArray) -> list[str]:
    """Name the axes along which no grid value is within one step of an end."""
    remarks = []
    for axis, values, value in zip("yz", grid_axes(config), controlled[1:3], strict=False):
        step = getattr(config.route.grid, f"{axis}_m").step
        if np.abs(values - value).min() > step * (1.0 + _ROUNDING):
            side, wanted = ("min", value + step) if value < values[0] else ("max", value - step)
            remarks.append(
                f"task.{name}.{axis}_m is {value:g}, off the grid: its {axis} goes from {values[0]:g} to "
                f"{values[-1]:g} in steps of {step:g}; let route.grid.{axis}_m.{side} be "
                f"{wanted:g} or {'less' if side == 'min' else 'more'}"
            )
    return remarks


def _isolated(config: Config, machine: Machine, name: str, controlled: FloatArray, mode: int) -> str:
    """Count why the grid points within a step of an end, in its working mode, cannot be joined to it."""
    lattice = grid_points(config)
    steps = step_sizes(config.route)
    away = np.abs(lattice[:, 1:] - controlled[1:]) / steps[1:]
    near = lattice[(away <= 1.0 + _ROUNDING).all(axis=1)]
    left = np.ones(len(near), dtype=bool)
    counts = []
    for what, refused in _refusals(config, machine, near, mode):
        if number := int((left & refused).sum()):
            counts.append(f"{number} {what}")
        left &= ~refused
    if left.any():
        counts.append(
            f"{int(left.sum())} are regions, but across a sign change of det H, across links or bodies that would pass "
            "through each other, or more than route.x_step_m away along X"
        )
    return (
        f"no move joins the {name} to anything: of the {len(near)} grid points within one step of it, in "
        f"{MODES[mode]}, {'; '.join(counts)}"
    )


def _refusals(config: Config, machine: Machine, near: FloatArray, mode: int) -> Iterator[tuple[str, BoolArray]]:
    """Yield what a region has to satisfy, in the order of evaluation, and which points (n, 5) do not."""
    machine = within_margins(config, machine)
    solution = inverse_kinematics(machine, near, np.full(len(near), mode))
    yield "are out of reach", ~solution.reachable
    rows = np.flatnonzero(solution.reachable)
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    windows = x_windows(machine, samples.q_m)
    checks = [(TRAVEL_REFUSED, windows[:, 0] <= windows[:, 1])]
    checks += [
        (limit.wording.refused_points, admits(limit, samples)) for limit in pose_limits(machine, config.route.kappa_max)
    ]
    for refused_points, kept in checks:
        refused = np.zeros(len(near), dtype=bool)
        refused[rows[~kept]] = True
        yield refused_points, refused
