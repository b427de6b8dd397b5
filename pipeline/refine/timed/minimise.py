"""The least duration on a mesh over tau and on a finer one, checked between the nodes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline

from pipeline.arrays import FloatArray
from pipeline.errors import ForwardKinematicsError, NoSolutionError
from pipeline.limits.kappa import path_cap
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.check import Violation, find_violations
from pipeline.refine.collocation.data import node_data
from pipeline.refine.collocation.ipopt import IpoptOptions, IpoptResult, ipopt_failure, solve_program
from pipeline.refine.corridor.cells import open_corridor
from pipeline.refine.corridor.cone import StraightEnd, straight_ends
from pipeline.refine.measure import measure_path, sample_path
from pipeline.refine.mesh import Mesh, midpoints
from pipeline.refine.problem import SCHATTEN, Problem
from pipeline.refine.result import Refinement
from pipeline.refine.splines import DEGREE
from pipeline.refine.timed.hull import least_motion_s
from pipeline.refine.timed.loads import LOADS, limits_loads, load_shares
from pipeline.refine.timed.motion import (
    MotionSolution,
    first_motion,
    halved,
    on_mesh,
    with_approaches_at,
)
from pipeline.refine.timed.program import TimedData, TimedGuess, TimedProgram, build_timed_program
from pipeline.refine.timed.visits import VisitNodes, visit_bounds, visits_at
from pipeline.solvers import interrupts_noted
from pipeline.status import Status

_COEFFICIENTS, _MESHES = 50, 2
"""Coefficients of the first mesh at least, and how many meshes there are at most, each with half the knot spans."""
_BELOW_CAP = 0.995
"""Share of the cap that nodes keep: kappa may be a little higher between two of them."""
_FIGURE_SAMPLES, _LOAD_SAMPLES = 5_001, 2_001
_OVERLOAD = 1.001
"""Share of a limit of loads that still counts as within it."""
_LOAD_ADVICE = "Raise refine.max_rounds."


def minimise_time(problem: Problem, refinement: Refinement) -> Refinement:
    """Find path and time law of least T / T_ref + w K / K_ref, beginning with a refined path.

    T_ref is the duration of a first motion along that path, and K_ref its integral of kappa.

    Raises
    ------
    NoSolutionError
        If IPOPT does not converge, or a requirement stays broken between the nodes; the last motion is in the
        `diagnosis`.
    """
    options, machine = problem.config.refine, _driven(problem)
    refined = replace(refinement.path, machine=machine)
    timed = replace(problem, machine=machine)
    start = first_motion(timed, refined, max(_COEFFICIENTS, options.coefficients))
    samples = sample_path(refinement.path, np.linspace(0.0, 1.0, _FIGURE_SAMPLES))
    kappa_integral = measure_path(samples, problem.steps).kappa_integral
    weights = 1.0 / start.motion_s, options.time_weight / kappa_integral
    solution, rounds = solve_and_check(timed, start, weights)
    meshes, change = 1, None
    while meshes < min(_MESHES, options.max_meshes):
        before = solution.motion_s
        solution, more = solve_and_check(timed, on_mesh(solution, halved(solution.mesh)), weights)
        meshes, rounds, change = meshes + 1, rounds + more, abs(solution.motion_s / before - 1.0)
        if change < options.tolerance:
            break
    return replace(
        refinement,
        path=replace(solution.path, machine=problem.machine),
        status=Status.CONVERGED,
        iterations=refinement.iterations + solution.iterations,
        rounds=refinement.rounds + rounds,
        meshes=refinement.meshes + meshes,
        mesh_change=change,
        nodes=len(solution.mesh.s),
        surrogate_integral=solution.integral,
    )


def _driven(problem: Problem) -> Machine:
    """Return the machine with the limits that its motion keeps: jerk counts only where `retime.jerk` asks for it."""
    machine = problem.machine
    return machine if problem.config.retime.jerk else replace(machine, jerk_mps3=np.full(len(ACTUATORS), np.inf))


def solve_and_check(
    problem: Problem, start: MotionSolution, weights: tuple[float, float]
) -> tuple[MotionSolution, int]:
    """Solve, check between the nodes, and add nodes where a requirement is broken, until none is; counts the checks.

    Raises
    ------
    NoSolutionError
        If IPOPT does not converge, or a requirement is still broken after the configured rounds.
    """
    solution, found, most = start, [], problem.config.refine.max_rounds
    for round_ in range(1, most + 1):
        solution, settled = solve(problem, solution, weights)
        problem.monitor.progress("refine: checking between the nodes")
        found = find_violations(problem.config, problem.route, solution.path, solution.coarse)
        found += _overloads(solution)
        if settled and not found:
            return solution, round_
        if found and round_ < most:
            mesh = _with_nodes_around(solution.mesh, np.concatenate([violation.s for violation in found]))
            solution = _repaired(solution, start, mesh)
    raise _broken(most, solution, found)


def solve(problem: Problem, start: MotionSolution, weights: tuple[float, float]) -> tuple[MotionSolution, bool]:
    """Solve the program of a mesh, and tell whether every visit is inside its knot span.

    Raises
    ------
    NoSolutionError
        If IPOPT does not converge; its last motion is in the `diagnosis`.
    """
    mesh, options = start.mesh, problem.config.refine
    label = f"refine: time, {len(mesh.s)} nodes, {mesh.coefficients} coefficients"
    problem.monitor.progress(f"{label}: building the program")
    guess = TimedGuess(start.path, start.visits)
    # CasADi swallows errors raised while it converts arguments, and Ctrl-C is one.
    with interrupts_noted():
        timed = build_timed_program(timed_data(problem, guess, start, weights), guess)
    ipopt = IpoptOptions(options.max_iterations, options.time_limit_s, "resumed" if start.solved else "timed")
    result = solve_program(timed.program, ipopt, label, problem.monitor)
    ends = straight_ends(problem.config, problem.route, start.coarse)
    solution, settled = _read(start, timed, ends, result)
    if not result.status.solved:
        raise ipopt_failure(result, solution.arrays)
    return solution, settled


def timed_data(problem: Problem, guess: TimedGuess, start: MotionSolution, weights: tuple[float, float]) -> TimedData:
    """Collect what the program of a mesh is written for."""
    config, mesh, kappa = problem.config, start.mesh, guess.nodes.kappa
    ends = max(kappa[0], kappa[-1])
    log_cap = np.full(len(mesh.s), np.log(max(_BELOW_CAP * path_cap(config), ends)))
    log_cap[[0, -1]] = np.inf
    bounds = open_corridor(config, problem.route, start.coarse, mesh.s)
    return TimedData(
        nodes=node_data(problem, mesh, bounds),
        exponent=SCHATTEN,
        log_cap=log_cap,
        visit_bounds=visit_bounds(config, problem.route, start.coarse),
        weights=weights,
    )


def _read(
    start: MotionSolution, timed: TimedProgram, ends: Sequence[StraightEnd], result: IpoptResult
) -> tuple[MotionSolution, bool]:
    """Read a solution; T is at least what keeps the limits exactly. Tells whether visits are inside their spans."""
    program, x = timed.program, result.x
    spline = BSpline(start.mesh.knots, program.spline_coefficients(x), DEGREE)
    motion_s = max(float(timed.motion(x)), least_motion_s(start.path.machine, spline))
    tau, at_edge = visits_at(timed.spans, np.array(timed.visit_shares(x)).ravel())
    path = replace(start.path, spline=spline, node_s=start.mesh.s, node_pose=program.poses(x), motion_s=motion_s)
    visits = VisitNodes(tau, np.array(timed.visit_poses(x)).T)
    return MotionSolution(
        mesh=start.mesh,
        path=path,
        visits=visits,
        coarse=with_approaches_at(start.coarse, ends, tau[len(tau) - len(ends) :]),
        integral=float(program.integral(x)),
        iterations=start.iterations + result.iterations,
    ), not at_edge


def _repaired(solution: MotionSolution, start: MotionSolution, mesh: Mesh) -> MotionSolution:
    """Transfer a motion to more nodes; where it has met another assembly mode, begin again from the start."""
    try:
        return on_mesh(solution, mesh)
    except ForwardKinematicsError:
        return replace(on_mesh(start, mesh), iterations=solution.iterations)


def _overloads(solution: MotionSolution) -> list[Violation]:
    """List where forces in motion, or speed and acceleration of the TCP, exceed their limits between the nodes."""
    if not limits_loads(solution.path.machine):
        return []
    tau = np.linspace(0.0, 1.0, _LOAD_SAMPLES)
    shares = load_shares(solution.path, tau, solution.motion_s)
    return [
        Violation(
            f"{name} too large, share of its limit", float(share.max()) - 1.0, tau[share > _OVERLOAD], _LOAD_ADVICE
        )
        for name, share in zip(LOADS, shares.T, strict=True)
        if share.max() > _OVERLOAD
    ]


def _with_nodes_around(mesh: Mesh, broken: FloatArray) -> Mesh:
    """Halve every interval of nodes that contains one of the parameters `broken` (m,), and its neighbours."""
    hit = np.clip(np.searchsorted(mesh.s, broken) - 1, 0, len(mesh.s) - 2)
    around = np.unique(np.clip(hit[:, None] + np.array([-1, 0, 1]), 0, len(mesh.s) - 2))
    return Mesh(np.union1d(mesh.s, midpoints(mesh.s)[around]), mesh.knots)


def _broken(rounds: int, solution: MotionSolution, found: list[Violation]) -> NoSolutionError:
    broken = "; ".join(map(str, found)) or "a visit still moves from knot span to knot span"
    return NoSolutionError(
        "refine",
        f"after {rounds} rounds the motion is still outside its limits between its nodes: {broken}",
        " ".join(dict.fromkeys(violation.advice for violation in found)) or "Raise refine.max_rounds.",
        {
            "status": Status.NOT_CONVERGED.value,
            "breaches": [str(violation) for violation in found],
            **solution.arrays,
        },
    )
