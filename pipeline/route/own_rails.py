"""The route on the rails as they are, where it was found on parallel ones (`with_parallel_rails`)."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import BoolArray
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import MODE_SIGNS, Machine
from pipeline.machine.kinematics import inverse_kinematics, newton
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.samples import PoseSamples
from pipeline.route.result import Route

_AWAY_M2 = 0.01
"""Discriminant of an arm so far from its serial singularity that rails a little off do not change its side."""
_CLOSED_M = 1e-9
_NEAR = 0.05
"""How far, in metres and radians, rails may move a step: farther off is another assembly."""


def on_own_rails(config: Config, machine: Machine, route: Route) -> Route:
    """Place every step of a route on the rails as they are; the route itself where these are parallel.

    A step keeps its pose, and the ends and poses to visit always do. Near a serial singularity, where the pose may be
    out of reach of rails that are a little off, it keeps its actuators, and the pose follows by forward kinematics.
    Objective and bound remain those of the parallel rails.

    Raises
    ------
    NoSolutionError
        When the machine cannot be there.
    """
    if machine.has_parallel_rails:
        return route
    solution = inverse_kinematics(machine, route.pose[:, CONTROLLED], route.modes)
    pose, miss = newton(machine, route.q_m, route.pose)
    # Where the pose is given, there is no choice.
    keeps_pose = _is_given(config, route) | (solution.reachable & (solution.discriminants_m2 > _AWAY_M2).all(axis=1))
    pose = np.where(keeps_pose[:, None], solution.pose, pose)
    q_m = np.where(keeps_pose[:, None], solution.q_m, route.q_m)
    lost = np.where(keeps_pose, ~solution.reachable, ~(miss < _CLOSED_M)) | ~(
        np.abs(pose - route.pose).max(axis=1) < _NEAR
    )
    if lost.any():
        step = int(np.argmax(lost))
        raise NoSolutionError(
            "route",
            f"step {step + 1} of the route, found for parallel rails, is out of reach of the rails as they are",
            "Choose a finer grid, or a lower route.kappa_max: regions are then farther from where the machine folds.",
            {"step": step, "mode": MODE_SIGNS[route.modes[step]].tolist()},
        )
    return replace(route, pose=pose, q_m=q_m, kappa=PoseSamples(machine, pose, q_m).kappa)


def _is_given(config: Config, route: Route) -> BoolArray:
    """Tell which steps are the start, the goal or a pose to visit. Shape (steps,)."""
    poses = [number for number, visit in enumerate(config.task.visit, start=1) if visit.pose is not None]
    given = np.isin(route.visits, poses)
    given[[0, -1]] = True
    return given
