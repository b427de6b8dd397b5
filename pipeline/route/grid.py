"""Grid points, and gates: the points between them where an arm passes its serial singularity.

A gate is the point of a grid edge along y or z where D_k = 0 for an arm k. Both working modes of that arm
have the same pose and the same carts there, C_k = 1 in (37), so that (38) lets the mode change exactly there.
"""

import numpy as np
from scipy.optimize import elementwise

from pipeline.config import AxisConfig, Config
from pipeline.machine.geometry import MODE_SIGNS, MODES, FloatArray, IntArray, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.triangle import dependent_angle, on_axis, third_discriminant

_ROUNDING = 1e-9
_ARM_BIT = np.array([4, 2, 1])
"""Bit of each arm in the number of a working mode."""


def grid_points(config: Config) -> FloatArray:
    """All controlled poses of the grid, x zero, within the tilt limits of the task. Shape (n, 5)."""
    y, z, rx, rz = grid_axes(config)
    mesh = np.meshgrid(y, z, rx, rz, indexing="ij")
    return np.column_stack([np.zeros(mesh[0].size), *(axis.ravel() for axis in mesh)])


def grid_axes(config: Config) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Grid values of y, z (metres), rx, rz (radians); a locked axis has zero alone."""
    grid, task = config.route.grid, config.task
    tilts = []
    for axis, step in (("rx", grid.rx_step_deg), ("rz", grid.rz_step_deg)):
        count = 0 if axis in task.locked_axes else int(np.floor(task.tilt_max_deg / step + _ROUNDING))
        values: FloatArray = np.deg2rad(step * np.arange(-count, count + 1, dtype=float))
        tilts.append(values)
    return _values(grid.y_m), _values(grid.z_m), tilts[0], tilts[1]


def _values(axis: AxisConfig) -> FloatArray:
    count = int(np.floor((axis.max - axis.min) / axis.step + _ROUNDING)) + 1
    values: FloatArray = axis.min + axis.step * np.arange(count, dtype=float)
    return values


def find_gates(config: Config, machine: Machine, lattice: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Find every gate on the grid's edges along y and z, in all the working modes that pass through it.

    ry, and with it D_1 and D_2, depends on the working mode of arm 3, so gates of arms 1 and 2 are searched
    for each of its two modes. Returns controlled poses (n, 5), modes (n,) and the arm (n,) from 1 to 3.
    """
    shape = tuple(len(axis) for axis in grid_axes(config))
    steps = {1: config.route.grid.y_m.step, 2: config.route.grid.z_m.step}
    found = []
    for arm, third in ((0, "L"), (0, "R"), (1, "L"), (1, "R"), (2, "L")):
        D = _discriminant(machine, lattice, arm, third).reshape(shape)
        for axis, step in steps.items():
            edges = _crossed_edges(D, axis - 1)
            points = _points_on_edges(machine, lattice[edges], axis, step, arm, third)
            found.append(_in_all_modes(points, arm, third))
    controlled, modes, gates = (np.concatenate(columns) for columns in zip(*found, strict=True))
    return controlled, modes, gates


def _discriminant(machine: Machine, controlled: FloatArray, arm: int, third: str) -> FloatArray:
    """D of one arm with arm 3 in mode `third`, continued beyond the reach of arm 3; NaN where ry does not exist.

    Without the continuation an edge that leaves arm 3's reach after it has passed a gate would lose the gate.
    """
    if arm == 2:
        return _third_discriminant(machine, controlled)
    modes = np.full(len(controlled), MODES.index("LL" + third))
    beyond = np.where(_third_discriminant(machine, controlled) < 0.0, 3, 0) if on_axis(machine) else None
    return inverse_kinematics(machine, controlled, modes, beyond).discriminants_m2[:, arm]


def _third_discriminant(machine: Machine, controlled: FloatArray) -> FloatArray:
    """D_3 with cart 3 abreast of its joint: zero where both modes of arm 3 meet, and smooth around it.

    Off the platform's y axis it depends on ry, which is then that of cart 3 abreast, too.
    """
    abreast = np.zeros(len(controlled))
    ry = abreast if on_axis(machine) else dependent_angle(machine, controlled, abreast)
    return third_discriminant(machine, controlled, ry)


def _crossed_edges(D: FloatArray, axis: int) -> IntArray:
    """Flat indices of the grid points from which an edge along `axis` starts on which D changes sign."""
    index = np.arange(D.size).reshape(D.shape)
    lower = np.take(D, np.arange(D.shape[axis] - 1), axis=axis)
    upper = np.take(D, np.arange(1, D.shape[axis]), axis=axis)
    start = np.take(index, np.arange(D.shape[axis] - 1), axis=axis)
    # A zero on a grid point counts as negative: its gate is found once, where D is positive next to it.
    crossed = ((lower > 0.0) != (upper > 0.0)) & np.isfinite(lower) & np.isfinite(upper)
    edges: IntArray = start[crossed]
    return edges


def _points_on_edges(machine: Machine, starts: FloatArray, axis: int, step: float, arm: int, third: str) -> FloatArray:
    """The points with D = 0 on edges that start at the given controlled poses. Shape (n, 5)."""
    if len(starts) == 0:
        return starts

    def at(offset: FloatArray, row: IntArray) -> FloatArray:
        points = starts[row].copy()
        points[:, axis] += offset
        return points

    rows = np.arange(len(starts))
    root = elementwise.find_root(
        lambda offset, row: _discriminant(machine, at(offset, row), arm, third),
        (np.zeros(len(starts)), np.full(len(starts), step)),
        args=(rows,),
    )
    # Where D jumps instead of passing zero (the triangle folds there), the edge has no gate.
    gates: FloatArray = at(root.x, rows)[root.success & (np.abs(root.f_x) < _ROUNDING)]
    return gates


def _in_all_modes(points: FloatArray, arm: int, third: str) -> tuple[FloatArray, IntArray, IntArray]:
    """Repeat gate points of an arm for every working mode that passes through them."""
    every = np.arange(len(MODES))
    modes = every if arm == 2 else every[MODE_SIGNS[:, 2] == (-1.0 if third == "L" else 1.0)]
    return (
        np.repeat(points, len(modes), axis=0),
        np.tile(modes, len(points)),
        np.full(len(points) * len(modes), arm + 1),
    )


def gate_bit(gates: IntArray) -> IntArray:
    """The bit of the working mode that may change at a region: that of its gate's arm, 0 where it is no gate."""
    return np.where(gates > 0, _ARM_BIT[gates - 1], 0)
