"""Stage two as a whole: a start from the coarse path, the program solved, checked between its nodes, solved again."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline

from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue, NoSolutionError
from pipeline.machine.geometry import FloatArray, Machine
from pipeline.machine.kinematics import newton
from pipeline.progress import Progress, silent
from pipeline.refine.between import Breach, breaches
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor import corridor, visit_parameters
from pipeline.refine.ipopt import Solution, solve_program
from pipeline.refine.measure import PathFigures, measure, sample_path
from pipeline.refine.motion import kappa_along
from pipeline.refine.nlp import Setting, Start, build_program
from pipeline.refine.result import Path, Refinement
from pipeline.refine.separation import find_separations
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route.metric import arc_length, step_sizes
from pipeline.route.result import Route
from pipeline.status import Status

_EVENNESS_FIRST, _EVENNESS = 10.0, 0.1
"""Cost of uneven speed along s, in units of kappa: much to begin with, in the end what no figure notices."""
_AIM = 0.97
"""Share of the coarse path's largest kappa that the integral's objective aims at, too: peaks are to come down."""
_BELOW_CAP = 0.995
"""Share of the cap aimed at: between two nodes kappa may be a little higher than at them."""
_GAIN = 0.001
"""Relative gain below which lowering the largest kappa further is not worth a solve."""
_LOWER = {"integral": 0.95, "mixed": 0.99, "maximum": 0.99}
"""The largest kappa is lowered in steps of this ratio, small ones where it is to go as low as it gets."""
_LOWERINGS, _LOWERING_ITERATIONS = 30, 60
"""So often at most, and each within so many iterations."""
_LOOKS = 2_001
"""Poses that the largest kappa is read off while it is lowered."""
_EXPONENTS = {"frobenius": 2.0, "schatten": 64.0}
"""Of the smooth kappa: at 64 it is within 6 per cent of the true one, whatever the singular values."""
_ENDS = np.array([0.0, 1.0])
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
    kappa_max: tuple[float, float]
    max_iterations: int
    peak: float
    length: float
    progress: Progress
    verbose: bool


@dataclass(frozen=True, eq=False)
class _Solve:
    """One solve: the path it gave, and how it ended."""

    path: Path
    solution: Solution
    integral: float

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
    ConfigError
        When refine.kappa_max is below kappa at the start or the goal.
    NoSolutionError
        When the route cannot be followed, IPOPT does not converge, or a promise stays broken between the nodes
        after the configured rounds; for the latter two the last path is in its `diagnosis`.
    """
    options, steps = config.refine, step_sizes(config.route)
    _require_cap(config, route)
    coarse = coarse_path(machine, route, steps)
    task = _Task(
        config=config,
        machine=machine,
        route=route,
        coarse=coarse,
        knots=clamped_knots(options.coefficients),
        steps=steps,
        kappa_max=_kappa_max(config, coarse),
        max_iterations=options.max_iterations,
        peak=0.0,
        length=float(arc_length(coarse.node_pose, steps)[-1]),
        progress=progress,
        verbose=verbose,
    )
    s = np.union1d(np.linspace(0.0, 1.0, options.nodes), visit_parameters(coarse, route))
    start, iterations = _warm_start(task, s, _first_start(task, s))
    for round_ in range(1, options.max_rounds + 1):
        solve = _solve(task, s, start, options.surrogate)
        iterations += solve.solution.iterations
        lowered, more = _lowered(task, s, solve)
        iterations += more
        progress("refine: checking between the nodes")
        # What was lowered has been checked already.
        found = breaches(config, solve.path) if lowered is solve else []
        solve = lowered
        if not found:
            return Refinement(
                path=solve.path,
                coarse=coarse,
                status=Status.CONVERGED,
                iterations=iterations,
                rounds=round_,
                nodes=len(s),
                surrogate_integral=solve.integral,
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
    """Solve roughly with the Frobenius kappa and at even speed first: cheap, and a start from which all goes well."""
    solve = _solve(task, s, start, "frobenius", rough=True)
    return solve.start, solve.solution.iterations


def _lowered(task: _Task, s: FloatArray, solve: _Solve) -> tuple[_Solve, int]:
    """Lower the largest kappa step by step as far as the objective asks for; also the iterations it took.

    It ends where the next step is no gain, does not converge or breaks a promise: the path before is kept. Start and
    goal are given, and so is their kappa.
    """
    iterations, figures = 0, _figures(task, solve)
    ends = float(kappa_along(solve.path, _ENDS).max())
    for _ in range(_LOWERINGS):
        largest = figures.kappa_max
        target = max(ends, task.kappa_max[0] if task.config.refine.objective == "integral" else 0.0)
        if largest <= target * (1.0 + _GAIN):
            break
        task.progress(f"refine: largest kappa {largest:.3f}, lowering it")
        step = _LOWER[task.config.refine.objective]
        lower = replace(
            task,
            kappa_max=(min(max(target, step * largest), task.kappa_max[1]), task.kappa_max[1]),
            max_iterations=_LOWERING_ITERATIONS,
            peak=1.0,
        )
        try:
            # The Frobenius kappa says nothing of the largest one.
            tried = _solve(lower, s, solve.start, "schatten")
        except NoSolutionError:
            break
        iterations += tried.solution.iterations
        there = _figures(task, tried)
        if _worth(task, there) >= _worth(task, figures) * (1.0 - _GAIN) or breaches(task.config, tried.path):
            break
        solve, figures = tried, there
    return solve, iterations


def _worth(task: _Task, figures: PathFigures) -> float:
    """What is to be small: the largest kappa, or its mean with the average of kappa along the path."""
    if task.config.refine.objective == "mixed":
        return (figures.kappa_max + figures.kappa_integral / task.length) / 2.0
    return figures.kappa_max


def _figures(task: _Task, solve: _Solve) -> PathFigures:
    return measure(sample_path(solve.path, np.linspace(0.0, 1.0, _LOOKS)), task.steps)


def _require_cap(config: Config, route: Route) -> None:
    """Refuse a cap on kappa that the start or the goal is above already."""
    ends = float(max(route.kappa[0], route.kappa[-1]))
    if config.refine.kappa_max is not None and config.refine.kappa_max < ends:
        raise ConfigError(
            [
                ConfigIssue(
                    "refine.kappa_max", f"is {config.refine.kappa_max:g}; kappa at the start or the goal is {ends:.2f}"
                )
            ]
        )


def _kappa_max(config: Config, coarse: Path) -> tuple[float, float]:
    """What is aimed at for the largest kappa, a little less than on the coarse path, and its cap."""
    largest = float(sample_path(coarse, np.linspace(0.0, 1.0, config.refine.check_points)).kappa.max())
    cap = min(config.refine.kappa_max or np.inf, config.route.kappa_max)
    return min(_AIM * largest, _BELOW_CAP * cap), cap


def _solve(task: _Task, s: FloatArray, start: Start, kind: str, rough: bool = False) -> _Solve:
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
        exponent=_EXPONENTS[kind],
        weights=(1.0, task.peak),
        kappa_max=task.kappa_max,
        evenness=_EVENNESS_FIRST if rough else _EVENNESS,
    )
    program = build_program(task.machine, setting, start)
    solution = solve_program(program, task.max_iterations, task.progress, f"refine ({kind})", task.verbose, rough)
    spline = BSpline(task.knots, program.spline_coefficients(solution.x), DEGREE)
    path = Path(task.machine, spline, s, program.poses(solution.x))
    solve = _Solve(path, solution, float(program.integral(solution.x)))
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
