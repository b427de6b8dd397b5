"""Stage two as a whole: a start from the coarse path, the program solved, checked between its nodes, solved again."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import FloatArray, Machine
from pipeline.machine.kinematics import newton
from pipeline.machine.symbolic import Smooth
from pipeline.progress import Progress, silent
from pipeline.refine.between import Breach, breaches
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor import corridor, visit_parameters
from pipeline.refine.ipopt import Solution, solve_program
from pipeline.refine.nlp import Setting, Start, build_program
from pipeline.refine.result import Path, Refinement
from pipeline.refine.separation import find_separations
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route
from pipeline.status import Status

_LOST = 0.5
"""A first pose farther than this (metres, radians) from the coarse path belongs to another assembly."""


@dataclass(frozen=True, eq=False)
class _Task:
    """What all solves of one refinement have in common."""

    config: Config
    machine: Machine
    route: Route
    coarse: Path
    knots: FloatArray
    steps: FloatArray
    progress: Progress
    verbose: bool


@dataclass(frozen=True, eq=False)
class _Solve:
    """One solve: the path it gave, and how it ended."""

    path: Path
    solution: Solution

    @property
    def start(self) -> Start:
        """Where the next solve may start."""
        return Start(self.path.node_pose, self.path.spline.c)

    @property
    def arrays(self) -> dict[str, object]:
        """The path as arrays, for the diagnosis of a failure."""
        return {
            "knots": self.path.spline.t,
            "coefficients": self.path.spline.c,
            "node_s": self.path.node_s,
            "node_pose": self.path.node_pose,
        }


def refine_path(
    config: Config, machine: Machine, route: Route, progress: Progress = silent, verbose: bool = False
) -> Refinement:
    """Find the smooth path of least integral of kappa in the corridor of a route, and check it between its nodes.

    Raises
    ------
    NoSolutionError
        When the route cannot be followed, IPOPT does not converge, or a promise stays broken between the nodes
        after the configured rounds; for the latter two the last path is in its `diagnosis`.
    """
    options, steps = config.refine, step_sizes(config.route)
    coarse = coarse_path(machine, route, steps)
    task = _Task(config, machine, route, coarse, clamped_knots(options.coefficients), steps, progress, verbose)
    s = np.union1d(np.linspace(0.0, 1.0, options.nodes), visit_parameters(coarse, route))
    start, iterations = _warm_start(task, s, _first_start(task, s))
    for round_ in range(1, options.max_rounds + 1):
        solve = _solve(task, s, start, options.objective)
        iterations += solve.solution.iterations
        progress("refine: checking between the nodes")
        found = breaches(config, solve.path)
        if not found:
            return Refinement(
                path=solve.path,
                coarse=coarse,
                status=Status.CONVERGED,
                iterations=iterations,
                rounds=round_,
                nodes=len(s),
                surrogate_integral=solve.solution.objective,
            )
        s, start = _more_nodes(s, solve, found)
    raise _broken(options.max_rounds, solve, found)


def _first_start(task: _Task, s: FloatArray) -> Start:
    """Fit splines to the coarse path; poses by forward kinematics from the coarse ones."""
    # Beside the nodes of the coarse path, enough samples for every coefficient to have some.
    samples = np.union1d(task.coarse.node_s, np.linspace(0.0, 1.0, 4 * task.config.refine.coefficients))
    coefficients = fit(task.knots, samples, task.coarse.q(samples))
    near = _poses_at(task.coarse, s)
    pose, miss = newton(task.machine, BSpline(task.knots, coefficients, DEGREE)(s), near)
    lost = ~(miss < 1e-6) | (np.abs(pose - near).max(axis=1) > _LOST)
    pose[lost] = near[lost]
    return Start(pose, coefficients)


def _warm_start(task: _Task, s: FloatArray, start: Start) -> tuple[Start, int]:
    """Solve roughly with the Frobenius kappa first: cheap, and from there the Schatten one ends lower more often."""
    if task.config.refine.objective == "frobenius":
        return start, 0
    solve = _solve(task, s, start, "frobenius", rough=True)
    return solve.start, solve.solution.iterations


def _solve(task: _Task, s: FloatArray, start: Start, kind: Smooth, rough: bool = False) -> _Solve:
    options = task.config.refine
    task.progress(f"refine: building the program ({len(s)} nodes, {kind})")
    q = BSpline(task.knots, start.coefficients, DEGREE)(s)
    reach = float(task.steps[:3].max())
    setting = Setting(
        s=s,
        knots=task.knots,
        corridor=corridor(task.config, task.route, task.coarse, s, float(np.deg2rad(options.tilt_margin_deg))),
        separations=find_separations(task.machine, start.pose, q, options.clearance_margin_m, reach),
        steps=task.steps,
        kind=kind,
    )
    program = build_program(task.machine, setting, start)
    solution = solve_program(program, options.max_iterations, task.progress, f"refine ({kind})", task.verbose, rough)
    spline = BSpline(task.knots, program.spline_coefficients(solution.x), DEGREE)
    solve = _Solve(Path(task.machine, spline, s, program.poses(solution.x)), solution)
    if not solution.status.solved:
        raise _failed(solve)
    return solve


def _more_nodes(s: FloatArray, solve: _Solve, found: list[Breach]) -> tuple[FloatArray, Start]:
    """Halve every interval of nodes with a breach, and give the next solve the path so far as its start."""
    broken = np.unique(np.searchsorted(s, np.concatenate([breach.s for breach in found])))
    broken = broken[(broken > 0) & (broken < len(s))]
    more = np.unique(np.concatenate([s, (s[broken - 1] + s[broken]) / 2.0]))
    near = _poses_at(solve.path, more)
    pose, miss = newton(solve.path.machine, solve.path.q(more), near)
    pose[~(miss < 1e-6)] = near[~(miss < 1e-6)]
    return more, Start(pose, solve.path.spline.c)


def _poses_at(path: Path, s: FloatArray) -> FloatArray:
    """Interpolate linearly between the poses known along a path, shape (n, 6)."""
    return np.stack([np.interp(s, path.node_s, column) for column in path.node_pose.T], axis=1)


def _failed(solve: _Solve) -> NoSolutionError:
    solution = solve.solution
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


def _broken(rounds: int, solve: _Solve, found: list[Breach]) -> NoSolutionError:
    return NoSolutionError(
        "refine",
        f"after {rounds} rounds the path still breaks between its nodes: {'; '.join(map(str, found))}",
        " ".join(dict.fromkeys(breach.advice for breach in found)),
        {
            "status": Status.NOT_CONVERGED.value,
            "breaches": [str(breach) for breach in found],
            **solve.arrays,
        },
    )
