"""The region table: every admissible pose and working mode of the grid, gates, start and goal.

A region is a controlled pose without x, a working mode and what follows from them; x enters only through
cart travel, so that each region has a window of admissible x. Rails that are not parallel to X are taken as if they
were (`with_parallel_rails`): stage one is coarse, and all that follows is about the rails as they are. Reach and travel
are checked first, then the limits of poses, cheap ones before costly ones.
"""

import math
from functools import partial

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits import admitted, pose_limits
from pipeline.limits.actuator_margins import within_margins
from pipeline.limits.actuators import x_windows
from pipeline.limits.approach import between_approaches
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import discriminants, inverse_kinematics
from pipeline.machine.pose import RY, full_pose
from pipeline.machine.rails import with_parallel_rails
from pipeline.machine.samples import PoseSamples
from pipeline.machine.triangle import dependent_angle
from pipeline.parallel import WORKERS, blocks, in_parallel
from pipeline.progress import QUIET, Monitor
from pipeline.route.memory import POINT_BYTES, ROW_BYTES, require_memory
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.route.regions.gates import find_gates
from pipeline.route.regions.grid import grid_points, grid_shape
from pipeline.route.regions.table import RegionTable
from pipeline.route.regions.task_rows import add_task_rows

__all__ = ["RegionTable", "build_regions", "grid_regions"]

_BLOCK = 4_096
"""Batch size: grid points, or gates, evaluated at a time."""
_LEAST_BLOCK = 64
_POINT_BYTES = 16_000
"""Memory of a grid point while its eight working modes are evaluated."""


def build_regions(
    config: Config, machine: Machine, monitor: Monitor = QUIET, grid: RegionTable | None = None
) -> RegionTable:
    """Compute the region table: grid, gates, then what the task adds, start and goal last, or their approach poses.

    `grid` is the result of `grid_regions`, if it is known already.

    Raises
    ------
    ConfigError
        If the machine cannot be at the start, the goal or a pose to visit.
    NoSolutionError
        If no region lies in a box to visit.
    """
    task_endpoints(config, machine)
    grid = grid_regions(config, machine, monitor) if grid is None else grid
    return add_task_rows(between_approaches(config), with_parallel_rails(machine), grid)


def grid_regions(config: Config, machine: Machine, monitor: Monitor = QUIET) -> RegionTable:
    """Compute the regions of grid and gates, which know nothing of start, goal and visits.

    They keep the margins at the ends of rails and strokes. What they depend on is `machine` (not its limits of motion),
    `task.tilt_max_deg`, `task.locked_axes`, `route.grid`, `route.kappa_max` and both margins of `refine`.

    Raises
    ------
    NoSolutionError
        When they would take up more than `route.memory_gb`.
    """
    require_memory(
        config.route, math.prod(grid_shape(config)) * POINT_BYTES, "the points of route.grid", "coarsen route.grid"
    )
    machine = with_parallel_rails(within_margins(config, machine))
    lattice = grid_points(config)
    monitor.progress("regions: gates", 0.0)
    controlled, modes, arms = find_gates(config, machine, lattice)
    size = _block_points(config)
    tasks = [partial(regions_at, config, machine, lattice[block]) for block in blocks(len(lattice), size)]
    tasks += [
        partial(admissible_regions, config, machine, controlled[block], modes[block], arms[block])
        for block in blocks(len(modes), size)
    ]
    tables, found = [], 0
    for table in in_parallel(tasks):
        tables.append(table)
        found += len(table)
        needed = found * ROW_BYTES + lattice.nbytes
        require_memory(config.route, needed, f"{found:,} regions and more", "coarsen route.grid")
        monitor.progress(f"regions: block {len(tables):,} of {len(tasks):,}", len(tables) / len(tasks))
    return RegionTable.concatenate(tables)


def _block_points(config: Config) -> int:
    """Return the batch size: few enough points for fast memory, and for each worker's share of it."""
    share = config.route.memory_gb * 1e9 / WORKERS
    return int(np.clip(share / _POINT_BYTES, _LEAST_BLOCK, _BLOCK))


def regions_at(config: Config, machine: Machine, points: FloatArray) -> RegionTable:
    """Find the regions at grid points (n, 5) in all eight working modes.

    ry and the reach of all arms depend on the mode of arm 3 alone: two cases instead of eight.
    """
    third = [dependent_angle(machine, points, np.full(len(points), side)) for side in (-1.0, 1.0)]
    reached = [(discriminants(machine, full_pose(points, ry)) >= 0.0).all(axis=1) for ry in third]
    # The mode of arm 3 is the lowest bit, so that the two cases alternate four times.
    row, mode = np.nonzero(np.tile(np.stack(reached, axis=1), len(MODES) // 2))
    ry_rad = np.stack(third, axis=1)[row, mode & 1]
    return admissible_regions(config, machine, points[row], mode, np.zeros_like(mode), ry_rad)


def admissible_regions(
    config: Config,
    machine: Machine,
    controlled: FloatArray,
    modes: IntArray,
    gates: IntArray,
    ry_rad: FloatArray | None = None,
) -> RegionTable:
    """Keep the candidates that are in reach, on their rails at some x, and within all limits of poses."""
    solution = inverse_kinematics(machine, controlled, modes, gates, ry_rad)
    windows = x_windows(machine, solution.q_m)
    rows = np.flatnonzero(solution.reachable & (windows[:, 0] <= windows[:, 1]))
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    kept, samples = admitted(pose_limits(machine, config.route.kappa_max), samples)
    rows = rows[kept]
    return RegionTable(
        controlled=controlled[rows],
        ry_rad=samples.pose[:, RY],
        modes=modes[rows],
        gates=gates[rows],
        q_m=samples.q_m,
        kappa=samples.kappa,
        det_sign=samples.det_sign,
        link_distance_m=samples.link_distance_m,
        x_window_m=windows[rows],
        visits=np.zeros(len(rows), dtype=np.int64),
    )
