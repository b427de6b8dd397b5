"""The region table: every admissible pose and working mode of the grid, gates, start and goal.

A region is a controlled pose without x, a working mode and what follows from them; x enters only through
cart travel, so that each region has a window of admissible x. Cheap filters come first: reach, strokes,
travel; then clearance; kappa, the dearest, last.
"""

from functools import partial

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.machine.clearance import link_distances, link_rail_distances
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import InverseSolution, discriminants, full_pose, inverse_kinematics
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.machine.triangle import dependent_angle
from pipeline.parallel import WORKERS, blocks, in_parallel
from pipeline.progress import Progress, silent
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.route.regions.gates import find_gates
from pipeline.route.regions.grid import grid_points
from pipeline.route.regions.table import RegionTable
from pipeline.route.regions.task_rows import add_task_rows

__all__ = ["RegionTable", "build_regions", "grid_regions"]

_BLOCK = 4_096
"""Grid points, or gates, that are looked at at once."""
_LEAST_BLOCK = 64
_POINT_BYTES = 16_000
"""What a grid point takes up while its eight working modes are looked at."""


def build_regions(
    config: Config, machine: Machine, progress: Progress = silent, grid: RegionTable | None = None
) -> RegionTable:
    """Compute the region table: grid, gates, then what the task adds, start and goal last.

    `grid` is the result of `grid_regions`, where it is known already.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start, the goal or a pose to visit.
    NoSolutionError
        When no region lies in a box to visit.
    """
    task_endpoints(config, machine)
    return add_task_rows(config, machine, grid_regions(config, machine, progress) if grid is None else grid)


def grid_regions(config: Config, machine: Machine, progress: Progress = silent) -> RegionTable:
    """Compute the regions of grid and gates, which know nothing of start, goal and visits.

    What they depend on is `machine` (not its limits), `task.tilt_max_deg`, `task.locked_axes`, `route.grid` and
    `route.kappa_max`.
    """
    lattice = grid_points(config)
    progress("regions: gates", 0.0)
    controlled, modes, arms = find_gates(config, machine, lattice)
    size = _block_points(config)
    tasks = [partial(_of_points, config, machine, lattice[block]) for block in blocks(len(lattice), size)]
    tasks += [
        partial(_admissible, config, machine, controlled[block], modes[block], arms[block])
        for block in blocks(len(modes), size)
    ]
    tables = []
    for table in in_parallel(tasks):
        tables.append(table)
        progress(f"regions: block {len(tables):,} of {len(tasks):,}", len(tables) / len(tasks))
    return RegionTable.concatenate(tables)


def _block_points(config: Config) -> int:
    """How many grid points to look at at once: few enough for fast memory, and for all workers' share of it."""
    share = config.route.memory_gb * 1e9 / WORKERS
    return int(np.clip(share / _POINT_BYTES, _LEAST_BLOCK, _BLOCK))


def _of_points(config: Config, machine: Machine, points: FloatArray) -> RegionTable:
    """Find the regions at grid points (n, 5) in all eight working modes.

    ry and the reach of all arms depend on the mode of arm 3 alone: two cases instead of eight.
    """
    third = [dependent_angle(machine, points, np.full(len(points), side)) for side in (-1.0, 1.0)]
    reached = [(discriminants(machine, full_pose(points, ry)) >= 0.0).all(axis=1) for ry in third]
    # The mode of arm 3 is the lowest bit, so that the two cases alternate four times.
    row, mode = np.nonzero(np.tile(np.stack(reached, axis=1), len(MODES) // 2))
    ry_rad = np.stack(third, axis=1)[row, mode & 1]
    return _admissible(config, machine, points[row], mode, np.zeros_like(mode), ry_rad)


def _admissible(
    config: Config,
    machine: Machine,
    controlled: FloatArray,
    modes: IntArray,
    gates: IntArray,
    ry_rad: FloatArray | None = None,
) -> RegionTable:
    """Keep of the candidates those in reach, within limits, clear of themselves and away from singularities."""
    solution = inverse_kinematics(machine, controlled, modes, gates, ry_rad)
    windows = _x_windows(machine, solution)
    telescopes = solution.q_m[:, 3:]
    strokes = (telescopes >= machine.strokes_m[:, 0]) & (telescopes <= machine.strokes_m[:, 1])
    rows = np.flatnonzero(solution.reachable & strokes.all(axis=1) & (windows[:, 0] <= windows[:, 1]))
    link_distance = link_distances(machine, solution.pose[rows], solution.q_m[rows, :3]).min(axis=1)
    clear = link_distance >= machine.link_link_m
    rows, link_distance = rows[clear], link_distance[clear]
    pose, q = solution.pose[rows], solution.q_m[rows]
    H = statics_matrix(machine, pose, q[:, :3])
    kappa = condition_number(H)
    return RegionTable(
        controlled=controlled[rows],
        ry_rad=pose[:, 4],
        modes=modes[rows],
        gates=gates[rows],
        q_m=q,
        kappa=kappa,
        det_sign=det_sign(H),
        link_distance_m=link_distance,
        x_window_m=windows[rows],
        visits=np.zeros(len(rows), dtype=np.int64),
    ).take((kappa < config.route.kappa_max) & _clear_of_rails(machine, pose, q))


def _clear_of_rails(machine: Machine, pose: FloatArray, q_m: FloatArray) -> BoolArray:
    if np.isnan(machine.link_rail_m):
        return np.ones(len(q_m), dtype=bool)
    clear: BoolArray = link_rail_distances(machine, pose, q_m[:, :3]).min(axis=1) >= machine.link_rail_m
    return clear


def _x_windows(machine: Machine, solution: InverseSolution) -> FloatArray:
    """[least, largest] x for which all three carts are on their rails, for solutions at x = 0. Shape (n, 2)."""
    carts = solution.q_m[:, :3]
    least = (machine.travel_m[:, 0] - carts).max(axis=1)
    largest = (machine.travel_m[:, 1] - carts).min(axis=1)
    return np.column_stack([least, largest])
