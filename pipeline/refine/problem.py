"""The problem of stage two, and solutions of it on a mesh."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.kappa import require_ends_below_cap
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton
from pipeline.progress import QUIET, Monitor
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor.cells import visit_parameters
from pipeline.refine.corridor.cone import straight_ends
from pipeline.refine.corridor.directions import end_directions
from pipeline.refine.measure import KappaFigures, PathSamples, measure_kappa, sample_path
from pipeline.refine.mesh import Mesh, even_mesh, with_straight_ends
from pipeline.refine.objective import OBJECTIVES, Objective
from pipeline.refine.result import Path
from pipeline.refine.smoothness import Smoothness
from pipeline.refine.splines import DEGREE, fit
from pipeline.route.metric import arc_length, step_sizes
from pipeline.route.result import Route

FROBENIUS, SCHATTEN = 2.0, 64.0
"""Exponents of the smooth kappa: with 64 it is within 6 per cent of the true one, whatever the singular values."""
_CLOSED_M = 1e-6
"""Largest miss of a link with which a node counts as closed."""
_LOST = 0.5
"""A node farther than this (metres, radians) from the path it was taken from belongs to another assembly mode."""
_FIGURE_SAMPLES = 2_001


@dataclass(frozen=True, eq=False)
class Problem:
    """What all programs of one refinement have in common.

    Attributes
    ----------
    steps : (5,)
        The metric: largest moves per step of the route.
    directions : (2, 5)
        Directions of the actuators at start and goal, NaN where they are free.
    """

    config: Config
    machine: Machine
    route: Route
    coarse: Path
    steps: FloatArray
    directions: FloatArray
    monitor: Monitor = QUIET

    @property
    def objective(self) -> Objective:
        """What is minimised."""
        return OBJECTIVES[self.config.refine.objective]

    @property
    def length(self) -> float:
        """Length of the coarse path in the metric: means of kappa are taken over it."""
        return float(arc_length(self.coarse.node_pose, self.steps)[-1])

    @cached_property
    def coarse_kappa_max(self) -> float:
        """Largest kappa of the coarse path."""
        return self._coarse_figures.kappa_max

    @cached_property
    def smoothness(self) -> Smoothness:
        """What a path costs that is not smooth."""
        return Smoothness.of(self.config.refine.smoothness, self._coarse_figures.kappa_integral, self.coarse)

    @cached_property
    def _coarse_figures(self) -> KappaFigures:
        coarse = self.coarse
        known = PathSamples(self.machine, coarse.node_pose, coarse.q(coarse.node_s), coarse.node_s)
        return measure_kappa(known, self.steps)


@dataclass(frozen=True, eq=False)
class MeshSolution:
    """A path on a mesh, the integral of its smooth kappa, and the iterations that led to it."""

    mesh: Mesh
    path: Path
    integral: float
    iterations: int

    @property
    def arrays(self) -> dict[str, object]:
        """The path as arrays, for the diagnosis of a failure."""
        return path_arrays(self.path)


def path_arrays(path: Path) -> dict[str, object]:
    """Give a path as arrays, for the diagnosis of a failure."""
    return {
        "knots": path.spline.t,
        "coefficients": path.spline.c,
        "node_s": path.node_s,
        "node_pose": path.node_pose,
    }


def build_problem(config: Config, machine: Machine, route: Route, monitor: Monitor = QUIET) -> Problem:
    """Join the route to a coarse path and collect what refining it takes.

    Raises
    ------
    ConfigError
        If refine.kappa_max is below kappa at the start or the goal, or a direction there is impossible.
    NoSolutionError
        If the route cannot be followed.
    """
    steps = step_sizes(config.route)
    require_ends_below_cap(config, (route.kappa[0], route.kappa[-1]))
    directions = end_directions(config, machine, route)
    return Problem(config, machine, route, coarse_path(machine, route, steps), steps, directions, monitor)


def first_mesh(problem: Problem, share: float = 1.0) -> Mesh:
    """Spread nodes and knots evenly, with a node at every visit, and denser where the path is to be straight.

    There are as many nodes as configured, or a `share` of them.
    """
    options, coarse, route = problem.config.refine, problem.coarse, problem.route
    nodes = max(round(share * options.nodes), options.coefficients)
    mesh = even_mesh(nodes, options.coefficients, visit_parameters(coarse, route))
    return with_straight_ends(mesh, np.array([end.s for end in straight_ends(problem.config, route, coarse)]))


def figures_of(problem: Problem, solution: MeshSolution) -> KappaFigures:
    """Measure kappa along the path of a solution."""
    return measure_kappa(sample_path(solution.path, np.linspace(0.0, 1.0, _FIGURE_SAMPLES)), problem.steps)


def fit_coarse(problem: Problem, mesh: Mesh) -> MeshSolution:
    """Fit splines to the coarse path; poses follow by forward kinematics from the coarse ones.

    An end with a direction is left or reached along it, as fast as the fit would be in any other direction.
    """
    coarse = problem.coarse
    # Beyond the nodes of the coarse path, enough samples for every coefficient to have some.
    samples = np.union1d(coarse.node_s, np.linspace(0.0, 1.0, 4 * mesh.coefficients))
    c = fit(mesh.knots, samples, coarse.q(samples))
    start, goal = problem.directions
    if np.isfinite(start).all():
        c[1] = c[0] + np.linalg.norm(c[1] - c[0]) * start
    if np.isfinite(goal).all():
        c[-2] = c[-1] - np.linalg.norm(c[-1] - c[-2]) * goal
    return _on_mesh(mesh, c, coarse, 0)


def transfer_to(solution: MeshSolution, mesh: Mesh) -> MeshSolution:
    """Transfer a solution to a finer mesh: the same curve, with more knots and nodes."""
    spline = solution.path.spline
    for knot in np.setdiff1d(mesh.knots, solution.mesh.knots):
        spline = spline.insert_knot(knot)
    return _on_mesh(mesh, spline.c, solution.path, solution.iterations)


def _on_mesh(mesh: Mesh, coefficients: FloatArray, reference: Path, iterations: int) -> MeshSolution:
    """Make a solution of coefficients (n, 5); the poses at its nodes are near those of a reference path."""
    near = np.stack([np.interp(mesh.s, reference.node_s, column) for column in reference.node_pose.T], axis=1)
    spline = BSpline(mesh.knots, coefficients, DEGREE)
    pose, miss = newton(reference.machine, spline(mesh.s), near)
    lost = ~(miss < _CLOSED_M) | (np.abs(pose - near).max(axis=1) > _LOST)
    pose[lost] = near[lost]
    return MeshSolution(mesh, Path(reference.machine, spline, mesh.s, pose), np.nan, iterations)
