"""The region table: every admissible pose and working mode of the grid, gates, start and goal.

A region is a controlled pose without x, a working mode and what follows from them; x enters only through
cart travel, so that each region has a window of admissible x. Cheap filters come first: reach, strokes,
travel; then kappa; then clearance.
"""

from dataclasses import dataclass, fields

import numpy as np

from pipeline.config import Config
from pipeline.machine.clearance import min_distances
from pipeline.machine.geometry import MODES, BoolArray, FloatArray, IntArray, Machine
from pipeline.machine.kinematics import InverseSolution, inverse_kinematics
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.progress import Progress, silent
from pipeline.route.ends import End, task_ends
from pipeline.route.grid import find_gates, grid_points
from pipeline.route.metric import CONTROLLED

_BLOCK = 100_000


@dataclass(frozen=True, eq=False)
class RegionTable:
    """One row per region; the last two rows are the start and the goal.

    Attributes
    ----------
    controlled : (n, 5)
        x, y, z, rx, rz; x is zero but for the start and the goal.
    ry_rad : (n,)
        The dependent angle.
    mode, gate : (n,)
        Working mode 0 to 7; arm (1 to 3) at its serial singularity, 0 for none.
    q_m : (n, 5)
        Actuator positions at that x.
    kappa, det_sign, link_distance_m : (n,)
        Condition number, sign of det H, least distance between axes.
    x_window_m : (n, 2)
        Least and largest x with all carts on their rails; for start and goal their own x.
    """

    controlled: FloatArray
    ry_rad: FloatArray
    mode: IntArray
    gate: IntArray
    q_m: FloatArray
    kappa: FloatArray
    det_sign: FloatArray
    link_distance_m: FloatArray
    x_window_m: FloatArray

    def __len__(self) -> int:
        return len(self.mode)

    @property
    def start(self) -> int:
        """Row of the start."""
        return len(self) - 2

    @property
    def goal(self) -> int:
        """Row of the goal."""
        return len(self) - 1

    @property
    def gates(self) -> int:
        """Number of gate regions."""
        return int(np.count_nonzero(self.gate))

    @property
    def pose(self) -> FloatArray:
        """Poses (x, y, z, rx, ry, rz), shape (n, 6)."""
        return np.column_stack([self.controlled[:, :4], self.ry_rad, self.controlled[:, 4]])

    def take(self, rows: IntArray | BoolArray) -> "RegionTable":
        """The table with only these rows."""
        return RegionTable(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


def build_regions(config: Config, machine: Machine, progress: Progress = silent) -> RegionTable:
    """Compute the region table: grid, gates, then start and goal as regions of their own.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start or at the goal.
    """
    ends = task_ends(config, machine)
    lattice = grid_points(config)
    progress("regions: gates", 0.0)
    parts = [_every_mode(lattice), find_gates(config, machine, lattice)]
    controlled, modes, gates = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    tables = []
    for begin in range(0, len(modes), _BLOCK):
        progress(f"regions: {begin:,} of {len(modes):,} candidates", begin / len(modes))
        block = slice(begin, begin + _BLOCK)
        tables.append(_admissible(config, machine, controlled[block], modes[block], gates[block]))
    tables += [_end_region(end) for end in ends]
    columns = {f.name: np.concatenate([getattr(table, f.name) for table in tables]) for f in fields(RegionTable)}
    return RegionTable(**columns)


def _every_mode(lattice: FloatArray) -> tuple[FloatArray, IntArray, IntArray]:
    controlled = np.repeat(lattice, len(MODES), axis=0)
    modes = np.tile(np.arange(len(MODES)), len(lattice))
    return controlled, modes, np.zeros_like(modes)


def _admissible(
    config: Config, machine: Machine, controlled: FloatArray, modes: IntArray, gates: IntArray
) -> RegionTable:
    """Keep of the candidates those in reach, within limits, away from singularities and clear of themselves."""
    solution = inverse_kinematics(machine, controlled, modes, gates)
    windows = _x_windows(machine, solution)
    telescopes = solution.q_m[:, 3:]
    with np.errstate(invalid="ignore"):
        strokes = (telescopes >= machine.strokes_m[:, 0]) & (telescopes <= machine.strokes_m[:, 1])
        rows = np.flatnonzero(solution.reachable & strokes.all(axis=1) & (windows[:, 0] <= windows[:, 1]))
    pose, q = solution.pose[rows], solution.q_m[rows]
    H = statics_matrix(machine, pose, q[:, :3])
    kappa, sign = condition_number(H), det_sign(H)
    link_distance, rail_distance = min_distances(machine, pose, q[:, :3])
    # Written so that an unchecked rail distance (NaN) refuses nothing.
    keep = (kappa < config.route.kappa_max) & ~(link_distance < machine.link_link_m)
    keep &= ~(rail_distance < machine.link_rail_m)
    return RegionTable(
        controlled=controlled[rows],
        ry_rad=pose[:, 4],
        mode=modes[rows],
        gate=gates[rows],
        q_m=q,
        kappa=kappa,
        det_sign=sign,
        link_distance_m=link_distance,
        x_window_m=windows[rows],
    ).take(keep)


def _x_windows(machine: Machine, solution: InverseSolution) -> FloatArray:
    """[least, largest] x for which all three carts are on their rails, for solutions at x = 0. Shape (n, 2)."""
    carts = solution.q_m[:, :3]
    least = (machine.travel_m[:, 0] - carts).max(axis=1)
    largest = (machine.travel_m[:, 1] - carts).min(axis=1)
    return np.column_stack([least, largest])


def _end_region(end: End) -> RegionTable:
    x = end.pose[0]
    return RegionTable(
        controlled=end.pose[None, CONTROLLED],
        ry_rad=end.pose[None, 4],
        mode=np.array([end.mode]),
        gate=np.array([0]),
        q_m=end.q_m[None],
        kappa=np.array([end.kappa]),
        det_sign=np.array([end.det_sign]),
        link_distance_m=np.array([end.link_distance_m]),
        x_window_m=np.array([[x, x]]),
    )
