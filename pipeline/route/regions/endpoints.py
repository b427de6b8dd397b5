"""Start, goal, approach poses and poses to visit: whether the machine can be there at all, before any search."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.limits import pose_limits
from pipeline.limits.actuator_margins import controlled_pose, given_poses
from pipeline.limits.actuators import cart_travel, x_windows
from pipeline.limits.approach import Approach, approaches
from pipeline.limits.avoid import boxes_to_avoid
from pipeline.limits.bodies import obstacle_distance
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples
from pipeline.machine.statics import det_sign, statics_matrix
from pipeline.route.regions.boxes import grown_boxes

_SINGULAR = 1e9
"""With a larger kappa there are no forces and no rates to show."""


@dataclass(frozen=True, eq=False)
class Endpoint:
    """The machine at the start or the goal, in its working mode (0 to 7); `samples` holds this one pose."""

    mode: int
    samples: PoseSamples

    @property
    def pose(self) -> FloatArray:
        """x, y, z, rx, ry, rz, shape (6,)."""
        return np.asarray(self.samples.pose[0], dtype=float)

    @property
    def q_m(self) -> FloatArray:
        """Actuator positions, shape (5,)."""
        return np.asarray(self.samples.q_m[0], dtype=float)

    @property
    def kappa(self) -> float:
        """Condition number."""
        return float(self.samples.kappa[0])

    @property
    def det_sign(self) -> float:
        """Sign of det H."""
        return float(self.samples.det_sign[0])


def task_endpoints(config: Config, machine: Machine) -> tuple[Endpoint, Endpoint]:
    """Place the machine at start and goal.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start, the goal, an approach pose or a pose to visit, when the goal or a visit
        repeats an end, or when det H has opposite signs there, so that every way between them meets a Type-II
        singularity.
    """
    issues: list[ConfigIssue] = []
    ends = []
    straight = {approach.title: approach for approach in approaches(config)}
    for key, pose in given_poses(config).items():
        end, found = place_pose(config, machine, key, pose)
        if key in straight:
            issues += [_of_approach(straight[key], issue) for issue in found]
        else:
            issues += found
            ends.append(end)
    if not issues and ends[0].mode == ends[1].mode and np.array_equal(ends[0].pose, ends[1].pose):
        issues.append(
            ConfigIssue("task.goal", "is the start itself, in the same working mode: there is nothing to plan")
        )
    if not issues and ends[0].det_sign != ends[1].det_sign:
        issues.append(
            ConfigIssue(
                "task.goal.mode",
                f"is {config.task.goal.mode}, where det H has the opposite sign of the start's: every way there meets "
                f"a Type-II singularity. Working modes at this pose with the start's sign: "
                f"{_modes_with_sign(machine, config.task.goal, ends[0].det_sign)}",
            )
        )
    if not issues:
        issues += _visit_issues(config, ends)
    if issues:
        raise ConfigError(issues)
    return ends[0], ends[1]


def _visit_issues(config: Config, ends: list[Endpoint]) -> list[ConfigIssue]:
    """Refuse to visit the start or the goal itself, and poses on the other side of a singularity."""
    issues = []
    numbers = [k for k, visit in enumerate(config.task.visit) if visit.pose is not None]
    for k, end in zip(numbers, ends[2:], strict=True):
        for name, other in zip(("start", "goal"), ends[:2], strict=True):
            if end.mode == other.mode and np.array_equal(end.pose, other.pose):
                issues.append(
                    ConfigIssue(
                        f"task.visit[{k}].pose", f"is the {name} itself, in the same working mode: leave the visit out"
                    )
                )
    for k, end in enumerate(ends[2:]):
        if not issues and end.det_sign != ends[0].det_sign:
            issues.append(
                ConfigIssue(
                    "task.visit",
                    f"has a pose ({k + 1} of {len(ends) - 2}) where det H has the opposite sign of the start's: every "
                    "way there meets a Type-II singularity",
                )
            )
    return issues


def _of_approach(approach: Approach, issue: ConfigIssue) -> ConfigIssue:
    """Say of the key of the approach what is wrong with its pose."""
    pose, part = approach.pose, issue.path.removeprefix(approach.title).removeprefix(".")
    where = f"x {pose.x_m:.6g}, y {pose.y_m:.6g}, z {pose.z_m:.6g} m"
    why = f"its {part} {issue.message}" if part else f"it {issue.message}"
    return ConfigIssue("refine.approach_m", f"is {approach.length_m:g}; {approach.title} is {where}: {why}")


def visited_pose(config: Config, machine: Machine, index: int, pose: PoseConfig) -> Endpoint:
    """Place the machine at a pose to visit, entry `index` of `task.visit`.

    Raises
    ------
    ConfigError
        When the machine cannot be there.
    """
    end, issues = place_pose(config, machine, f"task.visit[{index}].pose", pose)
    if issues:
        raise ConfigError(issues)
    return end


def place_pose(config: Config, machine: Machine, key: str, pose: PoseConfig) -> tuple[Endpoint, list[ConfigIssue]]:
    """Place the machine at a pose of the task, `key`, and say what of its limits it breaks there.

    The samples of the endpoint hold NaN where the pose is out of reach.
    """
    mode = MODES.index(pose.mode)
    solution = inverse_kinematics(machine, controlled_pose(pose)[None], np.array([mode]))
    end = Endpoint(mode, PoseSamples(machine, solution.pose, solution.q_m))
    if not solution.reachable[0]:
        return end, [ConfigIssue(key, _why_unreachable(solution.discriminants_m2[0]))]
    limits = [
        cart_travel(machine),
        *pose_limits(machine, config.route.kappa_max),
        *obstacle_distance.for_path(config, machine),
    ]
    broken = [ConfigIssue(key, message) for limit in limits for message in limit.violations(end.samples)]
    return end, _box_issues(config, key, end.samples.controlled[0]) + broken + _x_issues(machine, key, end)


def reached_ends(config: Config, machine: Machine) -> dict[str, Endpoint]:
    """Place the machine at "start" and "goal" whatever limits it breaks; leave out what is out of reach or singular."""
    found = {}
    for key in ("start", "goal"):
        end, _ = place_pose(config, machine, f"task.{key}", getattr(config.task, key))
        if np.isfinite(end.q_m).all() and end.kappa < _SINGULAR:
            found[key] = end
    return found


def _x_issues(machine: Machine, key: str, end: Endpoint) -> list[ConfigIssue]:
    """Say which x would put all carts on their rails, if they are not: nothing else of a pose depends on x.

    On rails that are not parallel, about which: the sentence gives advice, and the limit itself is exact.
    """
    x, at_zero = float(end.pose[0]), end.q_m.copy()
    at_zero[:3] -= x
    least, largest = x_windows(machine, at_zero[None])[0].tolist()
    if least <= x <= largest:
        return []
    least, largest = np.ceil(least * 1e4) / 1e4, np.floor(largest * 1e4) / 1e4
    if least > largest:
        return [ConfigIssue(f"{key}.x_m", f"is {x:g}; no other x puts all carts on their rails either")]
    about = "" if machine.has_parallel_rails else "about "
    return [ConfigIssue(f"{key}.x_m", f"is {x:g}; all carts are on their rails for {about}{least:g} to {largest:g}")]


def _why_unreachable(discriminants: FloatArray) -> str:
    short = [f"arm {k + 1}" for k in range(3) if discriminants[k] < 0.0]
    if short:
        return f"is out of reach for {' and '.join(short)}: the rail is farther from the platform than the link is long"
    return "is out of reach: the triangle of links 3a and 3c cannot close at this pose and mode"


def _box_issues(config: Config, key: str, controlled: FloatArray) -> list[ConfigIssue]:
    """Refuse a pose (5,) inside a box to avoid, or within its margin: no region there has a move."""
    if not config.task.avoid:
        return []
    issues = []
    for k, (box, grown) in enumerate(zip(boxes_to_avoid(config), grown_boxes(config), strict=True)):
        if box.inside(controlled):
            issues.append(ConfigIssue(key, f"is inside task.avoid[{k}]"))
        elif grown.inside(controlled):
            issues.append(
                ConfigIssue(
                    key,
                    f"is within route.avoid_margin of task.avoid[{k}] ({config.route.avoid_margin:g} grid steps), "
                    "where moves do not go",
                )
            )
    return issues


def _modes_with_sign(machine: Machine, pose: PoseConfig, sign: float) -> str:
    modes = np.arange(len(MODES))
    solution = inverse_kinematics(machine, np.repeat(controlled_pose(pose)[None], len(MODES), axis=0), modes)
    rows = modes[solution.reachable]
    signs = det_sign(statics_matrix(machine, solution.pose[rows], solution.q_m[rows, :3]))
    return ", ".join(MODES[mode] for mode in rows[signs == sign]) or "none"
