"""One solve of stage two: on a mesh, from a start, with an aim."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton
from pipeline.progress import Progress
from pipeline.refine.corridor import corridor
from pipeline.refine.integral.ipopt import Accuracy, Solution, solve_program
from pipeline.refine.integral.program import InitialGuess, ProgramData, build_program
from pipeline.refine.integral.separation import find_separations
from pipeline.refine.measure import PathFigures, measure_path, sample_path
from pipeline.refine.mesh import Mesh
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE, fit
from pipeline.route.metric import arc_length
from pipeline.route.result import Route
from pipeline.solvers import interrupts_noted

FROBENIUS, SCHATTEN = 2.0, 64.0
"""Exponents of the smooth kappa: with 64 it is within 6 per cent of the true one, whatever the singular values."""
_LOST = 0.5
"""A first pose farther than this (metres, radians) from the coarse path belongs to another assembly."""
_LOOKS = 2_001
"""Poses that the figures of a solve are read off."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What all solves of one refinement have in common.

    `steps` (5,) is the metric; `directions` (2, 5) are those of the actuators at start and goal, not a number where
    free.
    """

    config: Config
    machine: Machine
    route: Route
    coarse: Path
    steps: FloatArray
    directions: FloatArray
    progress: Progress
    verbose: bool

    @property
    def length(self) -> float:
        """Length of the coarse path in the metric: means of kappa are taken over it."""
        return float(arc_length(self.coarse.node_pose, self.steps)[-1])

    @cached_property
    def coarse_kappa_max(self) -> float:
        """Largest kappa of the coarse path."""
        s = np.linspace(0.0, 1.0, self.config.refine.check_points)
        return float(sample_path(self.coarse, s).kappa.max())


@dataclass(frozen=True)
class SolveOptions:
    """What a solve is to achieve, as in `nlp.ProgramData`, and how IPOPT goes about it."""

    exponent: float
    evenness: float
    max_iterations: int
    manner: Accuracy


@dataclass(frozen=True, eq=False)
class MeshSolution:
    """The path that a solve gave, on which mesh, the integral as its smooth kappa saw it, and iterations so far."""

    mesh: Mesh
    path: Path
    integral: float
    iterations: int

    @property
    def arrays(self) -> dict[str, object]:
        """The path as arrays, for the diagnosis of a failure."""
        return {
            "knots": self.path.spline.t,
            "coefficients": self.path.spline.c,
            "node_s": self.path.node_s,
            "node_pose": self.path.node_pose,
        }


def setting_of(problem: Problem, begin: MeshSolution, aim: SolveOptions) -> ProgramData:
    """Say what a solve from a path on a mesh is about."""
    mesh, margin = begin.mesh, problem.config.refine.clearance_margin_m
    q, reach = begin.path.q(mesh.s), float(problem.steps[:3].max())
    return ProgramData(
        s=mesh.s,
        knots=mesh.knots,
        corridor=corridor(problem.config, problem.route, problem.coarse, mesh.s),
        separations=find_separations(problem.machine, begin.path.node_pose, q, margin, reach),
        steps=problem.steps,
        exponent=aim.exponent,
        directions=problem.directions,
        evenness=aim.evenness,
    )


def solve_from(problem: Problem, begin: MeshSolution, aim: SolveOptions) -> MeshSolution:
    """Build and solve the program of a mesh, starting from a path on it that is known at the nodes.

    Raises
    ------
    NoSolutionError
        When IPOPT does not converge; its last path is in the `diagnosis`.
    """
    mesh, options = begin.mesh, problem.config.refine
    what = f"refine ({len(mesh.s)} nodes, {mesh.coefficients} coefficients)"
    problem.progress(f"{what}: building the program")
    start = InitialGuess(begin.path.node_pose, begin.path.spline.c)
    # CasADi's wrappers forget errors that come while they convert arguments, and Ctrl-C is one.
    with interrupts_noted():
        program = build_program(problem.machine, setting_of(problem, begin, aim), start)
    solution = solve_program(
        program, aim.max_iterations, options.time_limit_s, problem.progress, what, problem.verbose, aim.manner
    )
    spline = BSpline(mesh.knots, program.spline_coefficients(solution.x), DEGREE)
    path = Path(problem.machine, spline, mesh.s, program.poses(solution.x))
    solve = MeshSolution(mesh, path, float(program.integral(solution.x)), begin.iterations + solution.iterations)
    if not solution.status.solved:
        raise _failed(solve, solution)
    return solve


def figures_of(problem: Problem, solve: MeshSolution) -> PathFigures:
    """Measure the path of a solve."""
    return measure_path(sample_path(solve.path, np.linspace(0.0, 1.0, _LOOKS)), problem.steps)


def coarse_fit(problem: Problem, mesh: Mesh) -> MeshSolution:
    """Fit splines to the coarse path; poses by forward kinematics from the coarse ones.

    An end with a direction is left or reached in it from the first, as fast as it would be in any other.
    """
    coarse = problem.coarse
    # Beside the nodes of the coarse path, enough samples for every coefficient to have some.
    samples = np.union1d(coarse.node_s, np.linspace(0.0, 1.0, 4 * mesh.coefficients))
    c = fit(mesh.knots, samples, coarse.q(samples))
    start, goal = problem.directions
    if np.isfinite(start).all():
        c[1] = c[0] + np.linalg.norm(c[1] - c[0]) * start
    if np.isfinite(goal).all():
        c[-2] = c[-1] - np.linalg.norm(c[-1] - c[-2]) * goal
    return _near(coarse, mesh, c, 0)


def transferred_to(solve: MeshSolution, mesh: Mesh) -> MeshSolution:
    """Carry the path of a solve over to a finer mesh: the same curve, with more knots and nodes."""
    spline = solve.path.spline
    for knot in np.setdiff1d(mesh.knots, solve.mesh.knots):
        spline = spline.insert_knot(knot)
    return _near(solve.path, mesh, spline.c, solve.iterations)


def _near(near_path: Path, mesh: Mesh, coefficients: FloatArray, iterations: int) -> MeshSolution:
    near = np.stack([np.interp(mesh.s, near_path.node_s, column) for column in near_path.node_pose.T], axis=1)
    spline = BSpline(mesh.knots, coefficients, DEGREE)
    pose, miss = newton(near_path.machine, spline(mesh.s), near)
    lost = ~(miss < 1e-6) | (np.abs(pose - near).max(axis=1) > _LOST)
    pose[lost] = near[lost]
    return MeshSolution(mesh, Path(near_path.machine, spline, mesh.s, pose), np.nan, iterations)


def _failed(solve: MeshSolution, solution: Solution) -> NoSolutionError:
    worst = sorted(solution.violations.items(), key=lambda item: -item[1])[:3]
    broken = ", ".join(f"{name} by {value:.2e}" for name, value in worst if value > 1e-9)
    state = f"most violated: {broken}" if broken else "all constraints hold, but kappa can still be lowered"
    return NoSolutionError(
        "refine",
        f"IPOPT ended with {solution.message} after {solution.iterations} iterations; {state}",
        solution.status.advice,
        {
            "status": solution.status.value,
            "message": solution.message,
            "violations": solution.violations,
            **solve.arrays,
        },
    )
