"""The usable workspace of every working mode, and of all of them together: volumes by integration over the YZ plane.

Reach, strokes, kappa and clearances do not depend on x, which enters through the travel of the carts alone. At a tilt
(rx, rz) the usable poses of a working mode are therefore an interval of x over every point of the YZ plane,

    least = max_k (travel_k,least - c_k),  largest = min_k (travel_k,largest - c_k),  carts c_k at x = 0,

and a volume is the integral of its length over y and z. What several working modes reach together is the integral of
the length of the union of their intervals.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeline.arguments import require_number
from pipeline.arrays import FloatArray, IntArray
from pipeline.errors import UsageError
from pipeline.limits import admitted, pose_limits
from pipeline.limits.actuators import x_windows
from pipeline.machine.bodies.intervals import excluded_shifts, longest_free
from pipeline.machine.geometry import MODES, PRIMARY, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.rails import with_parallel_rails
from pipeline.machine.samples import PoseSamples
from pipeline.parallel import blocks

_BLOCK = 20_000
"""Batch size in poses: what is computed of them fits into a hundred megabytes."""
MOST_CELLS = 5_000_000
"""Most cells of a workspace: a gigabyte for the usable lengths in all working modes, and some minutes."""


@dataclass(frozen=True)
class WorkspaceSetting:
    """What counts as usable, beyond reach and the limits of the machine.

    Attributes
    ----------
    kappa_max : float
        Largest kappa.
    rx_rad, rz_rad : float
        The tilt at which the workspace is taken.
    step_m : float
        Side of the square cells of the YZ plane, of which the centres are looked at.

    Raises
    ------
    ArgumentError
        If one of them is no finite number, `kappa_max` is less than one, or the step is not positive.
    """

    kappa_max: float = 40.0
    rx_rad: float = 0.0
    rz_rad: float = 0.0
    step_m: float = 0.005

    def __post_init__(self) -> None:
        require_number("kappa_max", self.kappa_max, least=1.0)
        require_number("rx_rad", self.rx_rad)
        require_number("rz_rad", self.rz_rad)
        require_number("step_m", self.step_m, above=0.0)


@dataclass(frozen=True, eq=False)
class Workspace:
    """The usable interval of x over the cells of the YZ plane, in each of the eight working modes.

    Attributes
    ----------
    setting : WorkspaceSetting
        What it was computed for.
    y_m, z_m : (ny,), (nz,)
        Centres of the cells.
    least_m, largest_m : (8, nz, ny)
        Ends of the usable interval of x; NaN where a mode has none.
    """

    setting: WorkspaceSetting
    y_m: FloatArray
    z_m: FloatArray
    least_m: FloatArray
    largest_m: FloatArray

    @cached_property
    def lengths_m(self) -> FloatArray:
        """Length of the usable interval of each working mode, zero where there is none. Shape (8, nz, ny)."""
        return np.nan_to_num(self.largest_m - self.least_m)

    @cached_property
    def union_m(self) -> FloatArray:
        """Length of x that at least one working mode can use. Shape (nz, ny)."""
        return union_length(self.least_m, self.largest_m)

    @property
    def volumes_m3(self) -> FloatArray:
        """Usable volume of each working mode. Shape (8,)."""
        volumes: FloatArray = self.lengths_m.sum(axis=(1, 2)) * self.setting.step_m**2
        return volumes

    @property
    def areas_m2(self) -> FloatArray:
        """Part of the YZ plane that each working mode can use at some x. Shape (8,)."""
        areas: FloatArray = (self.lengths_m > 0.0).sum(axis=(1, 2)) * self.setting.step_m**2
        return areas

    @property
    def union_m3(self) -> float:
        """Volume that at least one working mode can use."""
        return float(self.union_m.sum() * self.setting.step_m**2)

    @property
    def union_area_m2(self) -> float:
        """Part of the YZ plane that at least one working mode can use at some x."""
        return float((self.union_m > 0.0).sum() * self.setting.step_m**2)


def usable_workspace(machine: Machine, setting: WorkspaceSetting) -> Workspace:
    """Find the usable interval of x in all working modes, at the centres of square cells of the YZ plane.

    The cells cover everything the primary links can reach. Volumes converge with the step: cells on the rim are
    counted whole or not at all, so that errors are of the first order in it, but mostly cancel.

    Raises
    ------
    UsageError
        When that makes more than `MOST_CELLS`.
    """
    _require_countable(machine, setting)
    y, z = (_centres(least, largest, setting.step_m) for least, largest in _extents(machine))
    mesh = np.meshgrid(y, z)
    controlled = np.zeros((mesh[0].size, 5))
    controlled[:, 1], controlled[:, 2] = mesh[0].ravel(), mesh[1].ravel()
    controlled[:, 3:] = setting.rx_rad, setting.rz_rad
    windows = np.stack([_windows_of_mode(machine, setting, controlled, mode) for mode in range(len(MODES))])
    least, largest = np.moveaxis(windows.reshape(len(MODES), len(z), len(y), 2), -1, 0)
    return Workspace(setting, y, z, least, largest)


def step_for(machine: Machine, step_m: float, most_cells: int) -> float:
    """Return a grid step that makes at most about so many cells for a machine: this one, or a larger one."""
    return max(step_m, float(np.sqrt(np.prod(_sides(machine)) / most_cells)))


def _sides(machine: Machine) -> FloatArray:
    """Lengths along y and z of what all primary links can reach; zero where they cannot meet. Shape (2,)."""
    least, largest = _extents(machine).T
    return np.asarray(np.maximum(largest - least, 0.0), dtype=float)


def _require_countable(machine: Machine, setting: WorkspaceSetting) -> None:
    sides = _sides(machine)
    cells = float(np.prod(np.ceil(sides / setting.step_m)))
    if cells > MOST_CELLS:
        least = step_for(machine, setting.step_m, MOST_CELLS)
        raise UsageError(
            f"a step of {setting.step_m:g} m makes {cells:,.0f} cells of the {sides[0]:.3g} m by {sides[1]:.3g} m that "
            f"this machine may reach; allowed are {MOST_CELLS:,}: take a step of at least {1.05 * least:.2g} m (--step)"
        )


def _windows_of_mode(machine: Machine, setting: WorkspaceSetting, controlled: FloatArray, mode: int) -> FloatArray:
    parts = [
        usable_windows(machine, setting.kappa_max, controlled[block], np.full(len(controlled[block]), mode))
        for block in blocks(len(controlled), _BLOCK)
    ]
    return np.concatenate(parts)


def usable_windows(machine: Machine, kappa_max: float, controlled: FloatArray, modes: IntArray) -> FloatArray:
    """[least, largest] usable x of controlled poses (n, 5), x zero, in working modes (n,); NaN for none. Shape (n, 2).

    Usable is what is in reach, with all carts on their rails, and within all limits of poses; of what bodies fixed to
    the frame leave of it, the longest piece. Rails are taken as parallel to X (`with_parallel_rails`).
    """
    machine = with_parallel_rails(machine)
    solution = inverse_kinematics(machine, controlled, modes)
    windows = x_windows(machine, solution.q_m)
    rows = np.flatnonzero(solution.reachable & (windows[:, 0] <= windows[:, 1]))
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    kept, samples = admitted(pose_limits(machine, kappa_max), samples)
    usable = np.full_like(windows, np.nan)
    usable[rows[kept]] = windows[rows[kept]]
    if machine.obstacles is not None:
        excluded = excluded_shifts(machine.obstacles, samples, windows[rows[kept]])
        usable[rows[kept]] = longest_free(windows[rows[kept]], excluded)
    return usable


def union_length(least: FloatArray, largest: FloatArray) -> FloatArray:
    """Length of the union of m intervals [least, largest], both (m, ...); NaN is none. Shape (...)."""
    # An interval of no length adds none, wherever it is.
    order = np.argsort(np.nan_to_num(least), axis=0)
    begin = np.take_along_axis(np.nan_to_num(least), order, axis=0)
    end = np.take_along_axis(np.nan_to_num(largest), order, axis=0)
    reached = np.maximum.accumulate(end, axis=0)
    covered = np.concatenate([begin[:1], reached[:-1]])
    length: FloatArray = np.maximum(end - np.maximum(begin, covered), 0.0).sum(axis=0)
    return length


def _extents(machine: Machine) -> FloatArray:
    """Least and largest y, and z, that all three primary links can reach at any tilt. Shape (2, 2)."""
    centres = machine.rails_m + machine.cart_offsets_m[PRIMARY, 1:]
    reach = machine.lengths_m[PRIMARY] + np.linalg.norm(machine.platform_points_m[PRIMARY], axis=1)
    return np.column_stack([(centres - reach[:, None]).max(axis=0), (centres + reach[:, None]).min(axis=0)])


def _centres(least: float, largest: float, step: float) -> FloatArray:
    """Centres of the cells from `least` on that cover the interval; one, out of reach, where it is empty."""
    count = max(int(np.ceil((largest - least) / step)), 1)
    centres: FloatArray = least + step * (np.arange(count, dtype=float) + 0.5)
    return centres
