"""Gates: the points of the grid's edges where an arm passes its serial singularity.

A gate is the point of a grid edge along y or z where D_k = 0 for an arm k. Both working modes of that arm
have the same pose and the same carts there, C_k = 1 in (37), so that (38) lets the mode change exactly there.
"""

import numpy as np
from scipy.optimize import elementwise

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.machine.geometry import MODE_SIGNS, MODES, Machine
from pipeline.machine.kinematics import discriminants
from pipeline.machine.pose import full_pose
from pipeline.machine.triangle import dependent_angle, on_axis, third_discriminant
from pipeline.parallel import blocks
from pipeline.route.metric import ROUNDING
from pipeline.route.regions.grid import grid_axes

_BLOCK = 8_192
"""Number of points whose discriminants are computed at a time."""
_CASES = ((0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, 0.0))
"""Arms whose gates are searched, and the side of its joint that cart 3 is on; at its own gate it is abreast."""
_ARM_BIT = np.array([4, 2, 1])
"""Bit of each arm in the number of a working mode."""


def find_gates(config: Config, machine: Machine, lattice: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Find every gate on the grid's edges along y and z, in all the working modes that pass through it.

    ry, and with it D_1 and D_2, depends on the working mode of arm 3, so gates of arms 1 and 2 are searched
    for each of its two modes. Returns controlled poses (n, 5), modes (n,) and the arm (n,) from 1 to 3.
    """
    shape = [len(axis) for axis in grid_axes(config)]
    on_grid = {side: _on_grid(machine, lattice, side) for side in (-1.0, 1.0, 0.0)}
    edges = []
    for case, (arm, side) in enumerate(_CASES):
        for axis, step in ((1, config.route.grid.y_m.step), (2, config.route.grid.z_m.step)):
            start = lattice[_crossed_edges(on_grid[side][:, arm].reshape(shape), axis - 1)]
            vector = np.zeros_like(start)
            vector[:, axis] = step
            edges.append((start, vector, np.full(len(start), case)))
    return _on_edges(machine, edges)


def gates_beside(config: Config, machine: Machine, points: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Find the gates on the grid's edges that begin at some of its points (n, 5), as `find_gates` does for all."""
    edges = []
    for case, (arm, side) in enumerate(_CASES):
        here = _discriminants(machine, points, np.full(len(points), side))[:, arm]
        for axis, of in ((1, config.route.grid.y_m), (2, config.route.grid.z_m)):
            vector = np.zeros_like(points)
            vector[:, axis] = of.step
            there = _discriminants(machine, points + vector, np.full(len(points), side))[:, arm]
            crossed = ((here > 0.0) != (there > 0.0)) & np.isfinite(here) & np.isfinite(there)
            crossed &= points[:, axis] + of.step <= of.max + ROUNDING
            edges.append((points[crossed], vector[crossed], np.full(np.count_nonzero(crossed), case)))
    return _on_edges(machine, edges)


def _on_edges(
    machine: Machine, edges: list[tuple[FloatArray, FloatArray, IntArray]]
) -> tuple[FloatArray, IntArray, IntArray]:
    """Find the gates on edges given by where they start, their vectors (n, 5) and their cases (n,)."""
    points, cases = _points_on_edges(machine, *(np.concatenate(column) for column in zip(*edges, strict=True)))
    found = [_in_all_modes(points[cases == case], arm, side) for case, (arm, side) in enumerate(_CASES)]
    controlled, modes, gates = (np.concatenate(columns) for columns in zip(*found, strict=True))
    return controlled, modes, gates


def _on_grid(machine: Machine, lattice: FloatArray, side: float) -> FloatArray:
    """Compute D of all arms at the grid points, with cart 3 on one side. Shape (n, 3)."""
    parts = [lattice[block] for block in blocks(len(lattice), _BLOCK)]
    return np.concatenate([_discriminants(machine, part, np.full(len(part), side)) for part in parts])


def _discriminants(machine: Machine, controlled: FloatArray, side: FloatArray) -> FloatArray:
    """Compute D of all arms (n, 3) with cart 3 on a side (n,), continued beyond its reach; NaN where ry does not exist.

    Without the continuation an edge that leaves arm 3's reach after it has passed a gate would lose the gate.
    With cart 3 abreast of its joint, D_3 is zero where both modes of arm 3 meet, and smooth around it.
    """
    if on_axis(machine):
        beyond = third_discriminant(machine, controlled, np.zeros(len(controlled))) < 0.0
        side = np.where(beyond, 0.0, side)
    return discriminants(machine, full_pose(controlled, dependent_angle(machine, controlled, side)))


def _crossed_edges(D: FloatArray, axis: int) -> IntArray:
    """Find the edges along `axis` on which D changes sign; gives flat indices of the grid points they start from."""
    index = np.arange(D.size).reshape(D.shape)
    lower = np.take(D, np.arange(D.shape[axis] - 1), axis=axis)
    upper = np.take(D, np.arange(1, D.shape[axis]), axis=axis)
    start = np.take(index, np.arange(D.shape[axis] - 1), axis=axis)
    # A zero on a grid point counts as negative: its gate is found once, where D is positive next to it.
    crossed = ((lower > 0.0) != (upper > 0.0)) & np.isfinite(lower) & np.isfinite(upper)
    return np.asarray(start[crossed])


def _points_on_edges(
    machine: Machine, start: FloatArray, vector: FloatArray, case: IntArray
) -> tuple[FloatArray, IntArray]:
    """Find the points with D = 0 on edges start + [0, 1] vector, both (n, 5), of cases (n,), and their cases."""
    if len(start) == 0:
        return start, case
    arm, side = np.array([arm for arm, _ in _CASES])[case], np.array([side for _, side in _CASES])[case]

    def discriminant(fraction: FloatArray, row: IntArray) -> FloatArray:
        D = _discriminants(machine, start[row] + fraction[:, None] * vector[row], side[row])
        return np.asarray(D[np.arange(len(row)), arm[row]], dtype=float)

    rows = np.arange(len(start))
    root = elementwise.find_root(discriminant, (np.zeros(len(start)), np.ones(len(start))), args=(rows,))
    # Where D jumps instead of passing zero (the triangle folds there), the edge has no gate.
    found = root.success & (np.abs(root.f_x) < ROUNDING)
    return (start + root.x[:, None] * vector)[found], case[found]


def _in_all_modes(points: FloatArray, arm: int, side: float) -> tuple[FloatArray, IntArray, IntArray]:
    """Repeat gate points of an arm for every working mode that passes through them."""
    every = np.arange(len(MODES))
    modes = every if arm == 2 else every[MODE_SIGNS[:, 2] == side]
    return (
        np.repeat(points, len(modes), axis=0),
        np.tile(modes, len(points)),
        np.full(len(points) * len(modes), arm + 1),
    )


def gate_bit(gates: IntArray) -> IntArray:
    """Give the bit of the working mode that may change at gates (n,) of these arms, 0 for none (0). Shape (n,)."""
    return np.where(gates > 0, _ARM_BIT[gates - 1], 0)
