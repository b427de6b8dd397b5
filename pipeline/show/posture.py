"""The machine at a pose as it is jogged: where it stands, what it keeps, and why the pose would be refused."""

from dataclasses import dataclass

import numpy as np

from pipeline.config import Config, PoseConfig
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.limits import Reading, read_limits, read_measures, task_pose_limits, unlimited_measures
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples
from pipeline.route.regions.endpoints import place_pose
from pipeline.route.regions.grid import grid_axes

_KEY = "task.start"
"""The pose is checked as if it were the start of the task."""
_POINTS = 12


@dataclass(frozen=True, eq=False)
class Posture:
    """The machine as it is shown for a pose that was asked for.

    Attributes
    ----------
    asked : PoseConfig
        The pose, and its working mode.
    samples : PoseSamples
        Where the machine stands (n = 1): there, or at the last pose in reach.
    reached : bool
        Whether it stands at the pose that was asked for.
    refusals : tuple of str
        Why the pose could not be the start of the task, in the words of `check`; empty if it could.
    readings : tuple of Reading
        What every limit reads where the machine stands.
    """

    asked: PoseConfig
    samples: PoseSamples
    reached: bool
    refusals: tuple[str, ...]
    readings: tuple[Reading, ...]

    @property
    def nearest(self) -> Reading:
        """The limit with the least room."""
        return min(self.readings, key=lambda reading: reading.room)

    @property
    def sides(self) -> tuple[float, ...]:
        """On which side of its platform joint each cart joint is: -1 (L) or +1 (R), three of them."""
        return tuple(np.where(self.samples.reach_m[0] < 0.0, -1.0, 1.0).tolist())


def place_machine(config: Config, machine: Machine, asked: PoseConfig, last: PoseSamples) -> Posture:
    """Place the machine at a pose; out of reach it stays where it was, at `last` (n = 1)."""
    end, issues = place_pose(config, machine, _KEY, asked)
    reached = bool(np.isfinite(end.samples.q_m).all())
    samples = end.samples if reached else last
    refusals = tuple(dict.fromkeys(_words(issue) for issue in [*_invalid(config, asked), *issues]))
    return Posture(asked, samples, reached, refusals, readings_at(config, machine, samples))


def readings_at(config: Config, machine: Machine, samples: PoseSamples) -> tuple[Reading, ...]:
    """Read every limit where the machine stands (n = 1), and what is measured without a limit."""
    limited = read_limits(task_pose_limits(config, machine), samples)
    return (*limited, *read_measures(unlimited_measures(config, machine), samples))


def first_posture(config: Config, machine: Machine) -> Posture:
    """Place the machine at the start, at the goal, or wherever on the grid of the route it can be.

    Raises
    ------
    ConfigError
        When it can be nowhere.
    """
    for pose in (config.task.start, config.task.goal, _somewhere(config, machine)):
        if pose is not None and (samples := in_reach(machine, pose)) is not None:
            return place_machine(config, machine, pose, samples)
    reason = "reaches no pose of route.grid without tilt in any working mode: links are too short, or rails too far"
    raise ConfigError([ConfigIssue("machine", reason)])


def in_reach(machine: Machine, pose: PoseConfig) -> PoseSamples | None:
    """Solve the machine at a pose (n = 1); None out of reach."""
    solution = inverse_kinematics(machine, controlled_pose(pose)[None], np.array([MODES.index(pose.mode)]))
    return PoseSamples(machine, solution.pose, solution.q_m) if solution.reachable[0] else None


def modes_in_reach(machine: Machine, pose: PoseConfig) -> dict[str, tuple[float, float]]:
    """Give kappa and the sign of det H of every working mode that reaches the pose."""
    modes = np.arange(len(MODES))
    solution = inverse_kinematics(machine, np.repeat(controlled_pose(pose)[None], len(modes), axis=0), modes)
    rows = np.flatnonzero(solution.reachable)
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    figures = zip(rows.tolist(), samples.kappa.tolist(), samples.det_sign.tolist(), strict=True)
    return {MODES[mode]: (kappa, sign) for mode, kappa, sign in figures}


def _invalid(config: Config, pose: PoseConfig) -> list[ConfigIssue]:
    """State what the configuration itself does not allow of a pose: tilts beyond the largest or of locked axes."""
    data = config.model_dump(mode="json")
    end = pose.model_dump(mode="json")
    data["task"] |= {"start": end, "goal": end, "visit": []}
    try:
        parse_config(data)
    except ConfigError as error:
        return [issue for issue in error.issues if issue.path.startswith(_KEY)]
    return []


def _words(issue: ConfigIssue) -> str:
    """State an issue of the pose without its key; of a part of the pose, with the name of the part."""
    return " ".join([*issue.path.removeprefix(_KEY).split("."), issue.message]).strip()


def _somewhere(config: Config, machine: Machine) -> PoseConfig | None:
    """Choose the pose of least kappa on the grid without tilt, in the middle of the rails."""
    y, z, *_ = grid_axes(config)
    mesh = np.meshgrid(np.linspace(y[0], y[-1], _POINTS), np.linspace(z[0], z[-1], _POINTS), np.arange(len(MODES)))
    y_m, z_m, modes = (values.ravel() for values in mesh)
    x_m = np.full(len(y_m), machine.travel_m.mean())
    controlled = np.column_stack([x_m, y_m, z_m, np.zeros((len(y_m), 2))])
    solution = inverse_kinematics(machine, controlled, modes.astype(np.int64))
    rows = np.flatnonzero(solution.reachable)
    if not len(rows):
        return None
    samples = PoseSamples(machine, solution.pose[rows], solution.q_m[rows])
    best = rows[int(samples.kappa.argmin())]
    x, y_best, z_best = (round(float(value), 3) for value in controlled[best, :3])
    return PoseConfig(x_m=x, y_m=y_best, z_m=z_best, mode=MODES[int(modes[best])])
