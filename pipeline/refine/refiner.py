"""Stage two as a whole: a first path, finer meshes until nothing changes, and checks between the nodes."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import QUIET, Monitor
from pipeline.refine.check import Violation, find_violations
from pipeline.refine.integral.minimise import minimise_integral
from pipeline.refine.mesh import adapted_mesh, with_nodes
from pipeline.refine.peak.lower import lower_peak
from pipeline.refine.problem import (
    MeshSolution,
    Problem,
    build_problem,
    figures_of,
    first_mesh,
    fit_coarse,
    transfer_to,
)
from pipeline.refine.result import Path, Refinement
from pipeline.refine.timed.minimise import minimise_time
from pipeline.route.result import Route
from pipeline.status import Status

Minimiser = Callable[[Problem, MeshSolution], MeshSolution]
"""Improves a solution on its mesh."""
Check = Callable[[Config, Route, Path, Path], list[Violation]]
"""Lists what a path breaks between its nodes, given its route and the coarse path."""


@dataclass(frozen=True, eq=False)
class MeshRefinement:
    """The solution on the finest mesh, how many meshes there were, and the relative change by the last one.

    The change is None if there was one mesh only, or the last finer one has no solution.
    """

    solution: MeshSolution
    meshes: int
    change: float | None


def refine_path(config: Config, machine: Machine, route: Route, monitor: Monitor = QUIET) -> Refinement:
    """Find the smooth path that minimises `refine.objective` in the corridor of a route, checked between its nodes.

    Raises
    ------
    ConfigError
        If refine.kappa_max is below kappa at the start or the goal, or a direction there is impossible.
    NoSolutionError
        If the route cannot be followed, no start leads to a path, or a requirement stays broken between the nodes
        after the configured rounds; for the latter two the last path is in its `diagnosis`.
    """
    problem = build_problem(config, machine, route, monitor)
    try:
        refinement = repair_between_nodes(problem, refine_mesh(problem, find_first_path(problem)))
        return minimise_time(problem, refinement) if problem.objective.timed else refinement
    except NoSolutionError as failure:
        raise advise_on_directions(failure, config) from failure


def find_first_path(problem: Problem, minimise: Minimiser = minimise_integral) -> MeshSolution:
    """Find a path on the first mesh, from one of two starts.

    IPOPT quickly goes a long way towards the least integral of kappa, and the descent covers the rest. Where IPOPT
    fails, or ends at a larger kappa than the coarse path has, and for objectives that do without IPOPT, the descent
    starts from the coarse path.

    Parameters
    ----------
    minimise : callable
        Minimises the integral of kappa on a mesh.

    Raises
    ------
    NoSolutionError
        If no start leads to a path.
    """
    progress = problem.monitor.progress
    initial = fit_coarse(problem, first_mesh(problem))
    if not problem.objective.starts_with_ipopt:
        return lower_peak(problem, initial)
    try:
        solution = lower_peak(problem, minimise(problem, initial))
    except NoSolutionError as failure:
        progress(f"refine: {failure.reason}; trying another start")
        return _from_other_start(problem, initial, failure)
    if figures_of(problem, solution).kappa_max <= problem.coarse_kappa_max:
        return solution
    try:
        other = lower_peak(problem, initial)
    except NoSolutionError as failure:
        progress(f"refine: {failure.reason}; keeping the first path")
        return solution
    return min(solution, other, key=lambda found: figures_of(problem, found).kappa_max)


def _from_other_start(problem: Problem, initial: MeshSolution, failure: NoSolutionError) -> MeshSolution:
    try:
        return lower_peak(problem, initial)
    except NoSolutionError as second:
        raise NoSolutionError(
            "refine", f"{failure.reason}; from another start, {second.reason}", failure.advice, failure.diagnosis
        ) from second


def refine_mesh(problem: Problem, solution: MeshSolution) -> MeshRefinement:
    """Solve on finer meshes until what is minimised changes by less than the tolerance."""
    options, progress, change = problem.config.refine, problem.monitor.progress, None
    value = _minimised(problem, solution)
    for meshes in range(1, options.max_meshes):
        mesh = adapted_mesh(solution.mesh, solution.path, problem.steps)
        try:
            finer = lower_peak(problem, transfer_to(solution, mesh))
        except NoSolutionError as error:
            progress(f"refine: {error.reason}; keeping the path on the coarser mesh")
            return MeshRefinement(solution, meshes, None)
        before, value = value, _minimised(problem, finer)
        solution, change = finer, abs(value / before - 1.0)
        progress(f"refine: {len(mesh.s)} nodes change the objective by {change:.2%}")
        if change < options.tolerance:
            return MeshRefinement(solution, meshes + 1, change)
    return MeshRefinement(solution, options.max_meshes, change)


def _minimised(problem: Problem, solution: MeshSolution) -> float:
    return problem.objective.minimised(figures_of(problem, solution), problem.length)


def repair_between_nodes(problem: Problem, refined: MeshRefinement, check: Check = find_violations) -> Refinement:
    """Check between the nodes, and add nodes where a requirement is broken, until none is.

    Raises
    ------
    NoSolutionError
        If a requirement is still broken after the configured rounds.
    """
    options, solution = problem.config.refine, refined.solution
    for round_ in range(1, options.max_rounds + 1):
        problem.monitor.progress("refine: checking between the nodes")
        found = check(problem.config, problem.route, solution.path, problem.coarse)
        if not found:
            return Refinement(
                path=solution.path,
                coarse=problem.coarse,
                status=Status.CONVERGED,
                iterations=solution.iterations,
                rounds=round_,
                meshes=refined.meshes,
                mesh_change=refined.change,
                nodes=len(solution.mesh.s),
                surrogate_integral=solution.integral,
            )
        if round_ < options.max_rounds:
            mesh = with_nodes(solution.mesh, np.concatenate([violation.s for violation in found]))
            solution = lower_peak(problem, replace(solution, mesh=mesh))
    raise _broken(options.max_rounds, solution, found)


def advise_on_directions(failure: NoSolutionError, config: Config) -> NoSolutionError:
    """Add the advice to leave out a direction at an end, where one is configured."""
    keys = [key for key in ("start_direction", "goal_direction") if getattr(config.refine, key) is not None]
    if not keys:
        return failure
    configured = " and ".join(f"refine.{key}" for key in keys)
    advice = f"{failure.advice} Or change {configured}, or leave it out."
    return NoSolutionError(failure.stage, failure.reason, advice, failure.diagnosis)


def _broken(rounds: int, solution: MeshSolution, found: list[Violation]) -> NoSolutionError:
    return NoSolutionError(
        "refine",
        f"after {rounds} rounds the path is still outside its limits between its nodes: {'; '.join(map(str, found))}",
        " ".join(dict.fromkeys(violation.advice for violation in found)),
        {
            "status": Status.NOT_CONVERGED.value,
            "breaches": [str(violation) for violation in found],
            **solution.arrays,
        },
    )
