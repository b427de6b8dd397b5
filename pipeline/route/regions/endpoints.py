"""Start and goal of the task: can the machine be there at all, before any search."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.machine.clearance import min_distances
from pipeline.machine.geometry import ACTUATORS, MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.route.metric import CONTROLLED
from pipeline.route.regions.boxes import boxes_to_avoid, grown_boxes


@dataclass(frozen=True, eq=False)
class Endpoint:
    """The machine at the start or the goal: pose (6,), actuators (5,) and what they imply."""

    mode: int
    pose: FloatArray
    q_m: FloatArray
    kappa: float
    det_sign: float
    link_distance_m: float
    rail_distance_m: float


def controlled_pose(pose: PoseConfig) -> FloatArray:
    """Read x, y, z in metres and rx, rz in radians. Shape (5,)."""
    return np.array([pose.x_m, pose.y_m, pose.z_m, np.deg2rad(pose.rx_deg), np.deg2rad(pose.rz_deg)])


def task_endpoints(config: Config, machine: Machine) -> tuple[Endpoint, Endpoint]:
    """Place the machine at start and goal.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start, the goal or a pose to visit, when the goal or a visit repeats an end,
        or when det H has opposite signs there, so that every way between them meets a Type-II singularity.
    """
    issues: list[ConfigIssue] = []
    ends = []
    visits = ((f"task.visit[{k}].pose", visit.pose) for k, visit in enumerate(config.task.visit))
    for key, pose in (("task.start", config.task.start), ("task.goal", config.task.goal), *visits):
        if pose is not None:
            end, found = _place(config, machine, key, pose)
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


def visited_pose(config: Config, machine: Machine, index: int, pose: PoseConfig) -> Endpoint:
    """Place the machine at a pose to visit, entry `index` of `task.visit`.

    Raises
    ------
    ConfigError
        When the machine cannot be there.
    """
    end, issues = _place(config, machine, f"task.visit[{index}].pose", pose)
    if issues:
        raise ConfigError(issues)
    return end


def _place(config: Config, machine: Machine, key: str, pose: PoseConfig) -> tuple[Endpoint, list[ConfigIssue]]:
    mode = MODES.index(pose.mode)
    solution = inverse_kinematics(machine, controlled_pose(pose)[None], np.array([mode]))
    if not solution.reachable[0]:
        return _unreachable(solution.pose[0], mode), [ConfigIssue(key, _why_unreachable(solution.discriminants_m2[0]))]
    q, full = solution.q_m[0], solution.pose[0]
    H = statics_matrix(machine, full, q[:3])
    link, rail = min_distances(machine, solution.pose, solution.q_m[:, :3])
    end = Endpoint(mode, full, q, float(condition_number(H)), float(det_sign(H)), float(link[0]), float(rail[0]))
    return end, _limit_issues(config, machine, key, end)


def _unreachable(pose: FloatArray, mode: int) -> Endpoint:
    return Endpoint(mode, pose, np.full(5, np.nan), np.nan, np.nan, np.nan, np.nan)


def _why_unreachable(discriminants: FloatArray) -> str:
    short = [f"arm {k + 1}" for k in range(3) if discriminants[k] < 0.0]
    if short:
        return f"is out of reach for {' and '.join(short)}: the rail is farther from the platform than the link is long"
    return "is out of reach: the triangle of links 3a and 3c cannot close at this pose and mode"


def _limit_issues(config: Config, machine: Machine, key: str, end: Endpoint) -> list[ConfigIssue]:
    issues = _box_issues(config, key, end.pose[CONTROLLED])
    for name, value, (least, largest) in zip(ACTUATORS, end.q_m, machine.actuator_limits_m, strict=True):
        if not least <= value <= largest:
            issues.append(ConfigIssue(key, f"needs {name} at {value:.4f} m; allowed are {least:g} to {largest:g} m"))
    if not end.kappa <= config.route.kappa_max:
        issues.append(
            ConfigIssue(key, f"has kappa {end.kappa:.1f}, above route.kappa_max ({config.route.kappa_max:g})")
        )
    if end.link_distance_m < machine.link_link_m:
        issues.append(
            ConfigIssue(
                key,
                f"has links {end.link_distance_m:.4f} m apart; "
                f"machine.clearance.link_link_m asks for {machine.link_link_m:g} m",
            )
        )
    if end.rail_distance_m < machine.link_rail_m:
        issues.append(
            ConfigIssue(
                key,
                f"has a link {end.rail_distance_m:.4f} m from a rail; "
                f"machine.clearance.link_rail_m asks for {machine.link_rail_m:g} m",
            )
        )
    return issues


def _box_issues(config: Config, key: str, controlled: FloatArray) -> list[ConfigIssue]:
    """Poses (5,) inside a box to avoid, or within its margin: no region there has a move."""
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
