"""Straight ends of a route: the moves from the start to its approach pose, and from that of the goal to the goal.

Stage one plans between the approach poses; the moves outside are given. The TCP moves straight, the platform does not
tilt, and no move is longer than a step of the route. Their costs are added to those of the route, and to its bounds.
"""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.limits.actuator_margins import controlled_pose
from pipeline.limits.approach import Approach, approaches
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.pose import RY
from pipeline.machine.samples import PoseSamples
from pipeline.route.cost.objectives import COSTS, route_cost
from pipeline.route.metric import ROUNDING, step_sizes
from pipeline.route.moves.check import check_moves
from pipeline.route.regions.table import RegionTable
from pipeline.route.result import Route


def require_straight_ends(config: Config, machine: Machine) -> None:
    """Follow the moves between the ends of the task and their approach poses.

    Raises
    ------
    ConfigError
        When one of them cannot be followed, or breaks a limit of moves: which, and why.
    """
    issues = []
    for approach in approaches(config):
        samples = _samples(config, machine, approach)
        ends = np.arange(len(samples) - 1)[:, None] + [0, 1]
        found = check_moves(config, machine, samples.pose[ends], samples.q_m[ends]).rejections
        reasons = dict.fromkeys(str(rejection) for rejection in found if rejection is not None)
        if reasons:
            way = f"from task.start to {approach.title}"
            if approach.name == "goal":
                way = f"from {approach.title} to it"
            message = f"is {approach.length_m:g}; the straight move {way} fails: {'; '.join(reasons)}"
            issues.append(ConfigIssue("refine.approach_m", message))
    if issues:
        raise ConfigError(issues)


def with_straight_ends(config: Config, machine: Machine, route: Route) -> Route:
    """Add the straight ends to a route between the approach poses; their steps have the region of the approach pose."""
    for approach in approaches(config):
        route = _joined(config, machine, route, approach)
    return route


def _joined(config: Config, machine: Machine, route: Route, approach: Approach) -> Route:
    samples = _samples(config, machine, approach)
    at_start = approach.name == "start"
    kept = slice(0, -1) if at_start else slice(1, None)
    count = len(samples) - 1

    def join(outside: FloatArray, inside: FloatArray) -> FloatArray:
        return np.concatenate([outside[kept], inside] if at_start else [inside, outside[kept]])

    def repeated(column: IntArray) -> IntArray:
        return np.pad(column, (count, 0) if at_start else (0, count), mode="edge")

    extra = _cost(config, machine, samples)
    search = route.search
    objective, bound = route.objective + extra, search.bound + extra
    gap = (objective - bound) / objective
    return replace(
        route,
        region=repeated(route.region),
        modes=repeated(route.modes),
        gates=np.pad(route.gates, (count, 0) if at_start else (0, count)),
        visits=np.pad(route.visits, (count, 0) if at_start else (0, count)),
        pose=join(samples.pose, route.pose),
        q_m=join(samples.q_m, route.q_m),
        kappa=join(samples.kappa, route.kappa),
        objective=objective,
        search=replace(
            search,
            bound=bound,
            gap=gap if gap > ROUNDING else 0.0,
            relaxation=search.relaxation + extra,
            threshold=search.threshold + extra,
        ),
    )


def _samples(config: Config, machine: Machine, approach: Approach) -> PoseSamples:
    """Place the machine along an approach, in the order of the motion."""
    distances = np.linspace(0.0, approach.length_m, approach.moves(step_sizes(config.route)) + 1)
    if approach.name == "goal":
        distances = distances[::-1]
    controlled = np.array([controlled_pose(approach.pose_at(distance)) for distance in distances.tolist()])
    solution = inverse_kinematics(machine, controlled, np.full(len(distances), MODES.index(approach.end.mode)))
    return PoseSamples(machine, solution.pose, solution.q_m)


def _cost(config: Config, machine: Machine, samples: PoseSamples) -> float:
    """Add up what the moves of an approach cost, as those of a table whose last row is the end of the last one."""
    none = np.zeros(len(samples), dtype=np.int64)
    x = samples.pose[:, 0]
    table = RegionTable(
        controlled=samples.controlled,
        ry_rad=samples.pose[:, RY],
        modes=none,
        gates=none,
        q_m=samples.q_m,
        kappa=samples.kappa,
        det_sign=samples.det_sign,
        link_distance_m=samples.link_distance_m,
        x_window_m=np.column_stack([x, x]),
        visits=none,
    )
    return route_cost(COSTS[config.route.objective](config.route, machine), table, np.arange(len(samples)), x)
