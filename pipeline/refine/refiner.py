"""Stage two as a whole: a path from the coarse one, finer meshes until nothing changes, checks between the nodes."""

from dataclasses import replace

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.limits.kappa import require_ends_below_cap
from pipeline.machine.geometry import Machine
from pipeline.progress import Progress, silent
from pipeline.refine.check import Violation, find_violations
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor import visit_parameters
from pipeline.refine.directions import end_directions
from pipeline.refine.mesh import adapted_mesh, even_mesh, with_nodes
from pipeline.refine.peak.lower import lower_peak
from pipeline.refine.result import Refinement
from pipeline.refine.solve import (
    FROBENIUS,
    SCHATTEN,
    MeshSolution,
    Problem,
    SolveOptions,
    coarse_fit,
    figures_of,
    solve_from,
    transferred_to,
)
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route
from pipeline.status import Status

_EVENNESS_FIRST, _EVENNESS = 10.0, 0.1
"""Cost of uneven speed along s, in units of kappa: much to begin with, in the end what no figure notices."""
_ROUGH_MOST = 150
"""Iterations of the rough solve at most: where IPOPT needs more it has lost its way, and the other start is faster."""


def refine_path(
    config: Config, machine: Machine, route: Route, progress: Progress = silent, verbose: bool = False
) -> Refinement:
    """Find the smooth path of least integral of kappa in the corridor of a route, and check it between its nodes.

    Raises
    ------
    ConfigError
        When refine.kappa_max is below kappa at the start or the goal, or a direction there cannot be kept.
    NoSolutionError
        When the route cannot be followed, no start leads to a path, or a promise stays broken between the nodes
        after the configured rounds; for the latter two the last path is in its `diagnosis`.
    """
    steps = step_sizes(config.route)
    require_ends_below_cap(config, (route.kappa[0], route.kappa[-1]))
    directions = end_directions(config, machine, route)
    coarse = coarse_path(machine, route, steps)
    problem = Problem(config, machine, route, coarse, steps, directions, progress, verbose)
    try:
        return _checked(problem, *_on_finer_meshes(problem, _first_solve(problem)))
    except NoSolutionError as failure:
        raise _with_directions(failure, config) from failure


def _checked(problem: Problem, solve: MeshSolution, meshes: int, change: float | None) -> Refinement:
    """Check between the nodes, and add nodes where a promise is broken, until none is."""
    options = problem.config.refine
    for round_ in range(1, options.max_rounds + 1):
        problem.progress("refine: checking between the nodes")
        found = find_violations(problem.config, problem.route, solve.path, problem.coarse)
        if not found:
            return Refinement(
                path=solve.path,
                coarse=problem.coarse,
                status=Status.CONVERGED,
                iterations=solve.iterations,
                rounds=round_,
                meshes=meshes,
                mesh_change=change,
                nodes=len(solve.mesh.s),
                surrogate_integral=solve.integral,
            )
        if round_ < options.max_rounds:
            mesh = with_nodes(solve.mesh, np.concatenate([breach.s for breach in found]))
            solve = lower_peak(problem, replace(solve, mesh=mesh))
    raise _broken(options.max_rounds, solve, found)


def _first_solve(problem: Problem) -> MeshSolution:
    """Solve on the first mesh, from one of two starts.

    For an integral of kappa IPOPT goes a long way fast, and the descent only the rest. Where it fails, or gets to a
    larger kappa than the coarse path has, and for the largest kappa alone, the descent begins with the coarse path.
    """
    options = problem.config.refine
    mesh = even_mesh(options.nodes, options.coefficients, visit_parameters(problem.coarse, problem.route))
    begin = coarse_fit(problem, mesh)
    if options.objective == "maximum":
        return lower_peak(problem, begin)
    try:
        solve = lower_peak(problem, solve_by_ipopt(problem, begin))
    except NoSolutionError as failure:
        problem.progress(f"refine: {failure.reason}; another start")
        return _other_start(problem, begin, failure)
    if figures_of(problem, solve).kappa_max <= problem.coarse_kappa_max:
        return solve
    try:
        other = lower_peak(problem, begin)
    except NoSolutionError as failure:
        problem.progress(f"refine: {failure.reason}; the first solve is kept")
        return solve
    return min(solve, other, key=lambda solve: figures_of(problem, solve).kappa_max)


def solve_by_ipopt(problem: Problem, begin: MeshSolution) -> MeshSolution:
    """Solve with the Frobenius kappa at even speed, roughly, and from there with the Schatten kappa."""
    most = problem.config.refine.max_iterations
    rough = solve_from(problem, begin, SolveOptions(FROBENIUS, _EVENNESS_FIRST, min(most, _ROUGH_MOST), "rough"))
    return solve_from(problem, rough, SolveOptions(SCHATTEN, _EVENNESS, most, "precise"))


def _other_start(problem: Problem, begin: MeshSolution, failure: NoSolutionError) -> MeshSolution:
    try:
        return lower_peak(problem, begin)
    except NoSolutionError as second:
        raise NoSolutionError(
            "refine",
            f"{failure.reason}; from another start, {second.reason}",
            failure.advice,
            failure.diagnosis,
        ) from second


def _on_finer_meshes(problem: Problem, solve: MeshSolution) -> tuple[MeshSolution, int, float | None]:
    """Solve on finer meshes until what is minimised changes by less than the tolerance.

    Also how many meshes there were, and the last relative change: None when there was one mesh, or none finer was
    solved.
    """
    options, change = problem.config.refine, None
    value = _minimised(problem, solve)
    for meshes in range(1, options.max_meshes):
        mesh = adapted_mesh(solve.mesh, solve.path, problem.steps)
        try:
            again = lower_peak(problem, transferred_to(solve, mesh))
        except NoSolutionError as error:
            problem.progress(f"refine: {error.reason}; the mesh before is kept")
            return solve, meshes, None
        before, value = value, _minimised(problem, again)
        solve, change = again, abs(value / before - 1.0)
        problem.progress(f"refine: {len(mesh.s)} nodes change what is minimised by {change:.2%}")
        if change < options.tolerance:
            return solve, meshes + 1, change
    return solve, options.max_meshes, change


def _minimised(problem: Problem, solve: MeshSolution) -> float:
    """The figure that the objective is about: the integral of kappa, its largest value, or the sum of mean and that."""
    figures, objective = figures_of(problem, solve), problem.config.refine.objective
    if objective == "integral":
        return figures.kappa_integral
    mean = figures.kappa_integral / problem.length if objective == "mixed" else 0.0
    return mean + figures.kappa_max


def _with_directions(failure: NoSolutionError, config: Config) -> NoSolutionError:
    """Advise to do without a direction at an end, where one was asked for."""
    keys = [key for key in ("start_direction", "goal_direction") if getattr(config.refine, key) is not None]
    if not keys:
        return failure
    wished = " and ".join(f"refine.{key}" for key in keys)
    return NoSolutionError(
        failure.stage, failure.reason, f"{failure.advice} Or change {wished}, or leave it out.", failure.diagnosis
    )


def _broken(rounds: int, solve: MeshSolution, found: list[Violation]) -> NoSolutionError:
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
