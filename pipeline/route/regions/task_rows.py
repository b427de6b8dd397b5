"""What the task adds to regions: boxes and obstacles cut windows, visits, start and goal are rows of their own."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import IntArray
from pipeline.config import Config, VisitConfig
from pipeline.errors import NoSolutionError
from pipeline.limits.avoid import Box
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.pose import RY
from pipeline.route.memory import ROW_BYTES, require_memory
from pipeline.route.metric import step_sizes
from pipeline.route.regions.boxes import cut_windows, grown_boxes
from pipeline.route.regions.endpoints import Endpoint, task_endpoints, visited_pose
from pipeline.route.regions.obstacles import cut_at_obstacles
from pipeline.route.regions.table import RegionTable

_ROUNDING = 1e-9


def add_task_rows(config: Config, machine: Machine, grid: RegionTable) -> RegionTable:
    """Add the task to a table of grid and gates: its last two rows are then the start and the goal.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start, the goal or a pose to visit.
    NoSolutionError
        When no region lies in a box to visit, or the rows would take up more than `route.memory_gb`.
    """
    start, goal = task_endpoints(config, machine)
    grid = without_obstructions(config, machine, grid)
    visits, rows = [], len(grid)
    for number, visit in enumerate(config.task.visit, start=1):
        visits.append(_visit_rows(config, machine, grid, number, visit))
        rows += len(visits[-1])
        _require_rows(config, rows, "visit")
    return RegionTable.concatenate([grid, *visits, endpoint_row(start), endpoint_row(goal)])


def without_obstructions(config: Config, machine: Machine, grid: RegionTable) -> RegionTable:
    """Cut the windows of a table of grid and gates at boxes to avoid and obstacles, and leave out what is inside.

    Raises
    ------
    NoSolutionError
        When the rows would take up more than `route.memory_gb`.
    """
    for box in grown_boxes(config) if config.task.avoid else []:
        grid = cut_windows([box], grid, step_sizes(config.route))
        _require_rows(config, len(grid), "avoid")
    grid = cut_at_obstacles(config, machine, grid)
    _require_rows(config, len(grid), "obstacles")
    return grid


def _visit_rows(config: Config, machine: Machine, grid: RegionTable, number: int, visit: VisitConfig) -> RegionTable:
    if visit.pose is not None:
        return endpoint_row(visited_pose(config, machine, number - 1, visit.pose), number)
    assert visit.box is not None
    box, rows = Box.of(visit.box), grid.take(rows_to_visit(grid, visit))
    windows = np.clip(rows.x_window_m, box.low[0], box.high[0])
    rows = replace(rows, x_window_m=windows, visits=np.full(len(rows), number))
    if len(rows) == 0:
        raise NoSolutionError(
            "regions",
            f"no region of the grid lies in task.visit[{number - 1}]; there are some {_extent(grid)}",
            "make the box larger than a grid step, allow other working modes there, or more tilt"
            + (", or avoid less around it: task.avoid, route.avoid_margin" if config.task.avoid else ""),
        )
    return rows


def rows_to_visit(grid: RegionTable, visit: VisitConfig) -> IntArray:
    """Find the rows of a table that lie in a box to visit, at some x, in one of its working modes."""
    assert visit.box is not None
    box = Box.of(visit.box)
    inside = box.across().depth_m(grid.controlled) >= -_ROUNDING
    if visit.modes:
        inside &= np.isin(grid.modes, [MODES.index(mode) for mode in visit.modes])
    least, largest = grid.x_window_m.T
    return np.flatnonzero(inside & (least <= box.high[0] + _ROUNDING) & (largest >= box.low[0] - _ROUNDING))


def _require_rows(config: Config, rows: int, key: str) -> None:
    what = f"{rows:,} regions, repeated for the {len(getattr(config.task, key)):,} entries of task.{key},"
    require_memory(config.route, rows * ROW_BYTES, what, f"leave out some of task.{key}, or coarsen route.grid")


def _extent(grid: RegionTable) -> str:
    """Say where a table has regions at all."""
    if len(grid) == 0:
        return "nowhere"
    low = [grid.x_window_m[:, 0].min(), *grid.controlled[:, 1:].min(axis=0)]
    high = [grid.x_window_m[:, 1].max(), *grid.controlled[:, 1:].max(axis=0)]
    sides = zip(("x_m", "y_m", "z_m", "rx_deg", "rz_deg"), low, high, strict=True)
    shown = [
        f"{key} from {np.rad2deg(least):.3g} to {np.rad2deg(most):.3g}"
        if key.endswith("deg")
        else f"{key} from {least:.3g} to {most:.3g}"
        for key, least, most in sides
    ]
    return "for " + ", ".join(shown)


def endpoint_row(end: Endpoint, visit: int = 0) -> RegionTable:
    """Give an endpoint as a table of one row, which has its own x only; `visit` is the entry it was laid out for."""
    samples, x = end.samples, end.pose[0]
    return RegionTable(
        controlled=samples.controlled,
        ry_rad=samples.pose[:, RY],
        modes=np.array([end.mode]),
        gates=np.array([0]),
        q_m=samples.q_m,
        kappa=samples.kappa,
        det_sign=samples.det_sign,
        link_distance_m=samples.link_distance_m,
        x_window_m=np.array([[x, x]]),
        visits=np.array([visit]),
    )
