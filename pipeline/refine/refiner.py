"""Stage two as a whole: a start from the coarse path, finer meshes until nothing changes, checks between the nodes."""

import numpy as np

from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue, NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import Progress, silent
from pipeline.refine.between import Breach, breaches
from pipeline.refine.coarse import coarse_path
from pipeline.refine.corridor import visit_parameters
from pipeline.refine.directions import end_directions
from pipeline.refine.ipopt import Manner
from pipeline.refine.mesh import even_mesh, finer, with_nodes
from pipeline.refine.peak import lowered
from pipeline.refine.result import Refinement
from pipeline.refine.solve import Aim, Problem, Solve, carried_start, coarse_start, figures_of, solve_on
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route
from pipeline.status import Status

_EXPONENTS = {"frobenius": 2.0, "schatten": 64.0}
"""Of the smooth kappa: at 64 it is within 6 per cent of the true one, whatever the singular values."""
_EVENNESS_FIRST, _EVENNESS = 10.0, 0.1
"""Cost of uneven speed along s, in units of kappa: much to begin with, in the end what no figure notices."""
_INTEGRAL, _NOTHING = (1.0, 0.0), (0.0, 0.0)
"""Weights of the integral of kappa and of the largest kappa."""


def refine_path(
    config: Config, machine: Machine, route: Route, progress: Progress = silent, verbose: bool = False
) -> Refinement:
    """Find the smooth path of least integral of kappa in the corridor of a route, and check it between its nodes.

    Raises
    ------
    ConfigError
        When refine.kappa_max is below kappa at the start or the goal, or a direction there cannot be kept.
    NoSolutionError
        When the route cannot be followed, IPOPT does not converge, or a promise stays broken between the nodes
        after the configured rounds; for the latter two the last path is in its `diagnosis`.
    """
    options, steps = config.refine, step_sizes(config.route)
    _require_cap(config, route)
    directions = end_directions(config, machine, route)
    coarse = coarse_path(machine, route, steps)
    problem = Problem(config, machine, route, coarse, steps, directions, progress, verbose)
    solve, iterations = _first_solve(problem)
    solve, meshes, change, more = _on_finer_meshes(problem, solve)
    iterations += more
    for round_ in range(1, options.max_rounds + 1):
        low, more = lowered(problem, solve, _EXPONENTS["schatten"], _EVENNESS)
        iterations += more
        progress("refine: checking between the nodes")
        # What was lowered has been checked already.
        found = breaches(config, route, solve.path, coarse) if low is solve else []
        solve = low
        if not found:
            return Refinement(
                path=solve.path,
                coarse=coarse,
                status=Status.CONVERGED,
                iterations=iterations,
                rounds=round_,
                meshes=meshes,
                mesh_change=change,
                nodes=len(solve.mesh.s),
                surrogate_integral=solve.integral,
            )
        if round_ < options.max_rounds:
            mesh = with_nodes(solve.mesh, np.concatenate([breach.s for breach in found]))
            solve = solve_on(problem, mesh, carried_start(solve, mesh), _final(config, "near"))
            iterations += solve.solution.iterations
    raise _broken(options.max_rounds, solve, found)


def _final(config: Config, manner: Manner) -> Aim:
    options = config.refine
    return Aim(_EXPONENTS[options.surrogate], _INTEGRAL, (0.0, 0.0), _EVENNESS, options.max_iterations, manner)


def _first_solve(problem: Problem) -> tuple[Solve, int]:
    """Solve on the first mesh, from a rough solution; from another one when that fails. Also the iterations it took.

    The Frobenius kappa at even speed is cheap, and a start from which all goes well; the other start only keeps what
    has to be kept, at even speed.
    """
    options = problem.config.refine
    mesh = even_mesh(options.nodes, options.coefficients, visit_parameters(problem.coarse, problem.route))
    roughs = [
        Aim(_EXPONENTS["frobenius"], weights, (0.0, 0.0), _EVENNESS_FIRST, options.max_iterations, "rough")
        for weights in (_INTEGRAL, _NOTHING)
    ]
    failures: list[NoSolutionError] = []
    for rough in roughs:
        try:
            first = solve_on(problem, mesh, coarse_start(problem, mesh), rough)
            solve = solve_on(problem, mesh, first.start, _final(problem.config, "precise"))
        except NoSolutionError as error:
            failures.append(error)
            problem.progress(f"refine: {error.reason}; another start")
        else:
            return solve, first.solution.iterations + solve.solution.iterations
    raise failures[0]


def _on_finer_meshes(problem: Problem, solve: Solve) -> tuple[Solve, int, float | None, int]:
    """Solve on finer meshes until the integral changes by less than the tolerance.

    Also how many meshes there were, the last relative change (None when there was one mesh, or none finer was
    solved), and the iterations it took.
    """
    options, iterations, change = problem.config.refine, 0, None
    integral = figures_of(problem, solve).kappa_integral
    for meshes in range(1, options.max_meshes):
        mesh = finer(solve.mesh, solve.path, problem.steps)
        try:
            again = solve_on(problem, mesh, carried_start(solve, mesh), _final(problem.config, "near"))
        except NoSolutionError as error:
            problem.progress(f"refine: {error.reason}; the mesh before is kept")
            return solve, meshes, None, iterations
        iterations += again.solution.iterations
        before, integral = integral, figures_of(problem, again).kappa_integral
        solve, change = again, abs(integral / before - 1.0)
        problem.progress(f"refine: {len(mesh.s)} nodes change the integral of kappa by {change:.2%}")
        if change < options.tolerance:
            return solve, meshes + 1, change, iterations
    return solve, options.max_meshes, change, iterations


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


def _broken(rounds: int, solve: Solve, found: list[Breach]) -> NoSolutionError:
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
