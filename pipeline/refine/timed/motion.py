"""A motion on a mesh over tau, made of another one: the first along a refined path, and the same on a finer mesh."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.machine.kinematics import newton
from pipeline.refine.coarse import SAMPLES_PER_MOVE, corner_parameters
from pipeline.refine.corridor.cone import StraightEnd
from pipeline.refine.mesh import Mesh, midpoints
from pipeline.refine.problem import Problem, path_arrays
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE
from pipeline.refine.timed.first_motion import Clock, first_clock, fit_motion
from pipeline.refine.timed.hull import least_motion_s
from pipeline.refine.timed.loads import limits_loads, unloaded_motion_s
from pipeline.refine.timed.visits import VisitNodes, visited_steps

NODES_EACH = 4
"""Nodes per coefficient: with fewer a pose may jump to another assembly mode between two of them."""


@dataclass(frozen=True, eq=False)
class MotionSolution:
    """A motion on a mesh over tau.

    Attributes
    ----------
    mesh : Mesh
        Nodes tau (k,) and knots.
    path : Path
        q(tau), with its duration.
    visits : VisitNodes
        When the visits are.
    coarse : Path
        The coarse path, with its steps at the tau at which the first motion is there, and approach poses at theirs.
    integral : float
        The integral of the smooth kappa; NaN before it is solved.
    iterations : int
        Iterations of IPOPT so far.
    """

    mesh: Mesh
    path: Path
    visits: VisitNodes
    coarse: Path
    integral: float
    iterations: int

    @property
    def motion_s(self) -> float:
        """Duration of the motion."""
        return float(self.path.motion_s or np.nan)

    @property
    def solved(self) -> bool:
        """Whether it is the solution of a program, on this mesh or another one."""
        return bool(np.isfinite(self.integral))

    @property
    def arrays(self) -> dict[str, object]:
        """The motion as arrays, for the diagnosis of a failure."""
        return {**path_arrays(self.path), "motion_s": self.motion_s}


def first_motion(problem: Problem, refined: Path, coefficients: int) -> MotionSolution:
    """Drive a refined path from rest to rest, about as fast as limits let it."""
    clock = first_clock(refined, coefficients)
    spline = fit_motion(refined, clock, coefficients)
    tau = np.linspace(0.0, 1.0, NODES_EACH * coefficients + 1)
    path = _path(refined, spline, (tau, refined.pose(clock.s_at(tau))), least_motion_s(problem.machine, spline))
    if limits_loads(problem.machine):
        path = replace(path, motion_s=unloaded_motion_s(path, tau, float(path.motion_s or np.nan)))
    coarse = problem.coarse
    visited = corner_parameters(coarse)[visited_steps(problem.config, problem.route, coarse)]
    visits = VisitNodes(clock.tau_at(visited), refined.pose(visited))
    return MotionSolution(Mesh(tau, spline.t), path, visits, coarse_in_time(coarse, clock), np.nan, 0)


def on_mesh(solution: MotionSolution, mesh: Mesh) -> MotionSolution:
    """Transfer a motion to a finer mesh: the same curve, with more knots and nodes."""
    spline = solution.path.spline
    for knot in np.setdiff1d(mesh.knots, solution.mesh.knots):
        spline = spline.insert_knot(knot)
    path = _path(solution.path, spline, (mesh.s, solution.path.pose(mesh.s)), solution.motion_s)
    return replace(solution, mesh=mesh, path=path)


def halved(mesh: Mesh) -> Mesh:
    """Halve every knot span, and every interval of nodes that is longer than the new spacing of nodes."""
    edges = np.unique(mesh.knots)
    knots = np.sort(np.concatenate([mesh.knots, midpoints(edges)]))
    spacing = 1.0 / (NODES_EACH * (len(knots) - DEGREE - 1))
    longer = np.diff(mesh.s) > 1.5 * spacing
    return Mesh(np.union1d(mesh.s, midpoints(mesh.s)[longer]), knots)


def with_approaches_at(coarse: Path, ends: Sequence[StraightEnd], tau: FloatArray) -> Path:
    """Move the approach poses of a coarse path over tau to other times (e,); what is between them stays."""
    was = corner_parameters(coarse)
    now, begin, finish = was.copy(), 0, len(was)
    for end, at in zip(ends, tau.tolist(), strict=True):
        if end.name == "start":
            begin = end.step + 1
            now[:begin] *= at / end.s
        else:
            finish = end.step
            now[finish:] = 1.0 - (1.0 - now[finish:]) * (1.0 - at) / (1.0 - end.s)
    least, largest = now[max(begin - 1, 0)], now[min(finish, len(was) - 1)]
    now[begin:finish] = now[begin:finish].clip(least, largest)
    return coarse_in_time(coarse, Clock(now, was))


def coarse_in_time(coarse: Path, clock: Clock) -> Path:
    """Put the corners of a coarse path at the tau at which the clock has them; moves between are even in tau."""
    corners = clock.tau_at(corner_parameters(coarse))
    corners[0], corners[-1] = 0.0, 1.0
    part = np.linspace(0.0, 1.0, SAMPLES_PER_MOVE + 1)[:-1]
    node_s = np.append((corners[:-1, None] + part * np.diff(corners)[:, None]).ravel(), 1.0)
    knots = clock.tau_at(coarse.spline.t)
    knots[:2], knots[-2:] = 0.0, 1.0
    return replace(coarse, spline=BSpline(knots, coarse.spline.c, coarse.spline.k), node_s=node_s)


def _path(near: Path, spline: BSpline, known: tuple[FloatArray, FloatArray], motion_s: float) -> Path:
    """Make a motion of splines, with poses at tau (k,) near known ones (k, 6); start and goal are exact."""
    tau, poses = known
    pose, _ = newton(near.machine, spline(tau), poses)
    pose[[0, -1]] = near.node_pose[[0, -1]]
    return Path(near.machine, spline, tau, pose, motion_s=motion_s)
