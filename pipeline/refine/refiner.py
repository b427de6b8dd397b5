"""Stage two as a whole: a start from the coarse path, the program solved, checked between its nodes, solved again."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import FloatArray, Machine
from pipeline.machine.kinematics import newton
from pipeline.progress import Progress, silent
from pipeline.refine.between import Breach, breaches
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor import corridor
from pipeline.refine.ipopt import Solution, solve_program
from pipeline.refine.nlp import Program, Setting, Start, build_program
from pipeline.refine.result import Path, Refinement
from pipeline.refine.separation import find_separations
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route
from pipeline.status import Status

_WATCH_FACTOR = 4.0
"""Pairs of links are watched that come nearer than this many clearances."""


@dataclass(frozen=True, eq=False)
class _Solve:
    """One solve: the path it gave, and how it ended."""

    path: Path
    start: Start
    solution: Solution


def refine_path(
    config: Config, machine: Machine, route: Route, progress: Progress = silent, verbose: bool = False
) -> Refinement:
    """Find the smooth path of least integral of kappa in the corridor of a route, and check it between its nodes.

    Raises
    ------
    NoSolutionError
        When IPOPT does not converge, or a promise stays broken between the nodes after the configured rounds.
    """
    options = config.refine
    coarse = coarse_path(machine, route, step_sizes(config.route))
    knots = clamped_knots(options.coefficients)
    s = np.linspace(0.0, 1.0, options.nodes)
    start = _first_start(machine, coarse, knots, s)
    start, iterations = _warm_start(config, machine, route, coarse, knots, s, start, progress, verbose)
    found: list[Breach] = []
    for round_ in range(1, options.max_rounds + 1):
        solve = _solve(config, machine, route, coarse, knots, s, start, options.objective, progress, verbose)
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
        s, start = _more_nodes(machine, s, solve, found)
    raise NoSolutionError(
        "refine",
        f"after {options.max_rounds} rounds the path still breaks between its nodes: {'; '.join(map(str, found))}",
        "raise refine.nodes, refine.clearance_margin_m or refine.tilt_margin_deg",
        {"status": Status.NOT_CONVERGED.value, "breaches": [str(breach) for breach in found]},
    )


def _first_start(machine: Machine, coarse: Path, knots: FloatArray, s: FloatArray) -> Start:
    """Fit splines to the coarse path; poses by forward kinematics from the coarse ones."""
    coefficients = fit(knots, coarse.node_s, coarse.q(coarse.node_s))
    q = BSpline(knots, coefficients, DEGREE)(s)
    near = np.stack([np.interp(s, coarse.node_s, column) for column in coarse.node_pose.T], axis=1)
    pose, miss = newton(machine, q, near)
    lost = ~(miss < 1e-6) | (np.abs(pose - near).max(axis=1) > 0.5)
    pose[lost] = near[lost]
    pose[[0, -1]] = coarse.node_pose[[0, -1]]
    return Start(pose, coefficients)


def _warm_start(
    config: Config,
    machine: Machine,
    route: Route,
    coarse: Path,
    knots: FloatArray,
    s: FloatArray,
    start: Start,
    progress: Progress,
    verbose: bool,
) -> tuple[Start, int]:
    """Solve with the Frobenius kappa first: it is cheap, and a good start for the Schatten one."""
    if config.refine.objective == "frobenius":
        return start, 0
    solve = _solve(config, machine, route, coarse, knots, s, start, "frobenius", progress, verbose)
    return solve.start, solve.solution.iterations


def _solve(
    config: Config,
    machine: Machine,
    route: Route,
    coarse: Path,
    knots: FloatArray,
    s: FloatArray,
    start: Start,
    kind: str,
    progress: Progress,
    verbose: bool,
) -> _Solve:
    options = config.refine
    progress(f"refine: building the program ({len(s)} nodes, {kind})")
    q = BSpline(knots, start.coefficients, DEGREE)(s)
    setting = Setting(
        s=s,
        knots=knots,
        corridor=corridor(config, route, coarse, s, float(np.deg2rad(options.tilt_margin_deg))),
        separations=find_separations(machine, start.pose, q, options.clearance_margin_m, float(step_sizes(config.route)[:3].max())),
        steps=step_sizes(config.route),
        kind=kind,
    )
    program = build_program(machine, setting, start)
    solution = solve_program(program, options.max_iterations, progress, f"refine ({kind})", verbose)
    if not solution.status.solved:
        raise _failed(solution)
    return _read(machine, program, setting, solution)


def _read(machine: Machine, program: Program, setting: Setting, solution: Solution) -> _Solve:
    pose, coefficients = program.poses(solution.x), program.spline_coefficients(solution.x)
    path = Path(machine, BSpline(setting.knots, coefficients, DEGREE), setting.s, pose)
    return _Solve(path, Start(pose, coefficients), solution)


def _failed(solution: Solution) -> NoSolutionError:
    worst = sorted(solution.violations.items(), key=lambda item: -item[1])[:3]
    broken = ", ".join(f"{name} by {value:.2e}" for name, value in worst if value > 1e-9) or "none"
    return NoSolutionError(
        "refine",
        f"IPOPT ended with {solution.message} after {solution.iterations} iterations; most violated: {broken}",
        solution.status.advice,
        {"status": solution.status.value, "message": solution.message, "violations": solution.violations},
    )


def _more_nodes(machine: Machine, s: FloatArray, solve: _Solve, found: list[Breach]) -> tuple[FloatArray, Start]:
    """Halve every interval of nodes with a breach, and give the next solve the path so far as its start."""
    broken = np.unique(np.searchsorted(s, np.concatenate([breach.s for breach in found])))
    broken = broken[(broken > 0) & (broken < len(s))]
    more = np.unique(np.concatenate([s, (s[broken - 1] + s[broken]) / 2.0]))
    near = np.stack([np.interp(more, s, column) for column in solve.start.pose.T], axis=1)
    pose, miss = newton(machine, solve.path.q(more), near)
    pose[~(miss < 1e-6)] = near[~(miss < 1e-6)]
    return more, Start(pose, solve.start.coefficients)
