"""The nonlinear program of stage two solved in other ways: other solvers, actuators not lifted, SciPy.

kappa is the Frobenius one here, written out so that every solver can differentiate it; all of them start from the
splines fitted to the coarse path.
"""

import time
from collections.abc import Callable, Iterator
from typing import Any

import casadi as ca
import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, minimize

from pipeline.config import Config
from pipeline.machine import build_machine
from pipeline.machine.symbolic import statics_function
from pipeline.progress import silent
from pipeline.refine import coarse_path
from pipeline.refine.corridor import visit_parameters
from pipeline.refine.directions import end_directions
from pipeline.refine.integral.program import InitialGuess, Program, build_program
from pipeline.refine.mesh import even_mesh
from pipeline.refine.peak.constraints import Limit, of_actuators
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.lower import peak_problem
from pipeline.refine.peak.speed import chord_slopes
from pipeline.refine.peak.sqp import PeakProblem, integral_slope
from pipeline.refine.solve import FROBENIUS, MeshSolution, Problem, SolveOptions, coarse_fit, setting_of
from pipeline.refine.splines import basis
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import CONTROLLED, step_sizes

EVENNESS = 10.0
SOLVERS: dict[str, dict[str, Any]] = {
    "ipopt": {"ipopt": {"linear_solver": "mumps", "print_level": 0, "sb": "yes", "tol": 1e-5, "max_iter": 3_000}},
    "uno": {"uno": {"logger": "SILENT"}},
    "fatrop": {"structure_detection": "none", "fatrop": {"print_level": 0, "max_iter": 3_000}},
    "madnlp": {"madnlp": {"print_level": 6}},
}


def problem_of(config: Config) -> Problem:
    """Plan the route that is refined."""
    machine, steps = build_machine(config.machine), step_sizes(config.route)
    route = plan_route(config, machine, build_regions(config, machine))
    coarse = coarse_path(machine, route, steps)
    directions = end_directions(config, machine, route)
    return Problem(config, machine, route, coarse, steps, directions, silent, verbose=False)


def first_fit(problem: Problem, nodes: int, coefficients: int) -> MeshSolution:
    """Fit splines to the coarse path on an even mesh."""
    return coarse_fit(problem, even_mesh(nodes, coefficients, visit_parameters(problem.coarse, problem.route)))


def solve_program(config: Config, nodes: int, coefficients: int, solver: str, lifted: bool) -> Iterator[dict[str, Any]]:
    """Solve the written-out program with a solver of CasADi, actuators among the unknowns or put in their place."""
    problem = problem_of(config)
    begin = first_fit(problem, nodes, coefficients)
    setting = setting_of(problem, begin, SolveOptions(FROBENIUS, EVENNESS, 1, "rough"))
    begun = time.perf_counter()
    program = build_program(problem.machine, setting, InitialGuess(begin.path.node_pose, begin.path.spline.c))
    written = _written_out(program, problem, begin)
    written, bounds, x0 = (written, _bounds(program), program.start) if lifted else _in_place(program, begin, written)
    try:
        solve = ca.nlpsol("peer", solver, written, {"error_on_fail": False, "print_time": False, **SOLVERS[solver]})
    except RuntimeError as error:
        yield {"outcome": "not in this wheel" if "not found" in str(error) else "failed to build"}
        return
    yield {"build_s": time.perf_counter() - begun, "unknowns": len(x0), "outcome": "not solved in the limit"}
    begun = time.perf_counter()
    result = solve(x0=x0, lbx=bounds[0], ubx=bounds[1], lbg=bounds[2], ubg=bounds[3])
    stats = solve.stats()
    yield {
        "solve_s": time.perf_counter() - begun,
        "iterations": stats.get("iter_count"),
        "objective": float(result["f"]),
        "outcome": "solved" if stats["success"] else str(stats.get("return_status", "failed")),
    }


def _bounds(program: Program) -> tuple[np.ndarray, ...]:
    return (*program.variable_bounds, *program.constraint_bounds)


def _written_out(program: Program, problem: Problem, begin: MeshSolution) -> dict[str, ca.MX]:
    """Replace the kappa that brings its own derivatives by one that CasADi differentiates."""
    x, k = program.problem["x"], program.nodes
    pose, q = ca.reshape(x[: 6 * k], 6, k), ca.reshape(x[6 * k : 11 * k], 5, k)
    distance = ca.sqrt(
        ca.sum1(((pose[list(CONTROLLED), 1:] - pose[list(CONTROLLED), :-1]) / problem.steps) ** 2) + 1e-8
    )
    kappa = _frobenius(problem).map(k)(pose, q)
    length = x[-1]
    deviation = distance / ca.DM(np.diff(begin.mesh.s)).T - length
    uneven = ca.dot(ca.DM(np.diff(begin.mesh.s)).T, deviation**2) / problem.length
    f = ca.dot(distance, kappa[1:] + kappa[:-1]) / 2.0 + EVENNESS * uneven
    return {"x": x, "f": f, "g": program.problem["g"]}


def _frobenius(problem: Problem) -> ca.Function:
    """|H|_F |H^-1|_F with H'H = L L' and |H^-1|_F = |L^-1|_F, (pose, q) -> kappa."""
    pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
    H = statics_function(problem.machine)(pose, q)
    L = ca.chol(H.T @ H).T
    inverse = ca.solve(L, ca.SX.eye(6))
    return ca.Function("frobenius", [pose, q], [ca.norm_fro(H) * ca.norm_fro(inverse)])


def _in_place(
    program: Program, begin: MeshSolution, written: dict[str, ca.MX]
) -> tuple[dict[str, ca.MX], tuple[np.ndarray, ...], np.ndarray]:
    """Put basis @ coefficients where actuators of nodes are, and drop them with the equations that tied them."""
    k, x0 = program.nodes, program.start
    keep = np.r_[: 6 * k, 11 * k : len(x0)]
    x = ca.MX.sym("x", len(keep))
    c = ca.reshape(x[6 * k : 6 * k + 5 * program.coefficients], 5, program.coefficients)
    q = c @ ca.DM(basis(begin.mesh.knots, begin.mesh.s).toarray()).T
    both = ca.Function("both", [written["x"]], [written["f"], written["g"]])
    f, g = both.call([ca.vertcat(x[: 6 * k], ca.vec(q), x[6 * k :])], True, False)
    tied = next(block for block in program.blocks if block.name == "spline")
    rows = np.r_[: tied.begin, tied.end : g.numel()]
    low, high, g_low, g_high = _bounds(program)
    problem = {"x": x, "f": f, "g": g[rows.tolist()]}
    return problem, (low[keep], high[keep], g_low[rows], g_high[rows]), x0[keep]


def solve_with_scipy(config: Config, nodes: int, coefficients: int, method: str) -> Iterator[dict[str, Any]]:
    """Least integral of kappa over the coefficients alone, with the limits and slopes of the descent."""
    problem = problem_of(config)
    found = peak_problem(problem, first_fit(problem, nodes, coefficients))
    assert found is not None
    ground, start = found
    known: dict[bytes, Iterate] = {}

    def at(x: np.ndarray) -> Iterate:
        if x.tobytes() not in known:
            known.clear()
            known[x.tobytes()] = iterate_at(ground.looks, x.reshape(-1, 5), start.pose) or start
        return known[x.tobytes()]

    low, high = np.tile(ground.actuator_limits_m.T, (1, coefficients))
    x0 = start.coefficients.ravel()
    low[:5] = high[:5] = x0[:5]
    low[-5:] = high[-5:] = x0[-5:]
    yield {"unknowns": len(x0), "outcome": "not solved in the limit"}
    begun = time.perf_counter()
    result = minimize(
        lambda x: at(x).integral,
        np.clip(x0, low, high),
        jac=lambda x: _integral_slope(ground, at(x)),
        method=method,
        bounds=Bounds(low, high),
        constraints=[_constraint(ground, at, start)],
        options={"maxiter": 3_000},
    )
    yield {
        "solve_s": time.perf_counter() - begun,
        "iterations": int(result.nit),
        "objective": float(result.fun),
        "outcome": "solved" if result.success else str(result.message),
    }


def _integral_slope(ground: PeakProblem, iterate: Iterate) -> np.ndarray:
    looks = ground.looks
    by_kappa = of_actuators(looks, np.arange(len(looks.s)), iterate.kappa_slope)
    return integral_slope(looks, iterate, by_kappa)[:-2]


def _constraint(ground: PeakProblem, at: Callable[[np.ndarray], Iterate], start: Iterate) -> NonlinearConstraint:
    """All limits as one constraint; what they say of the length is put in terms of the coefficients."""
    rows = [limit for limit in ground.limits(start) if not _is_length(limit)]
    low, high = (np.concatenate([getattr(limit, side) for limit in rows]) for side in ("low", "high"))

    def values(x: np.ndarray) -> np.ndarray:
        return np.concatenate([limit.value for limit in ground.limits(at(x)) if not _is_length(limit)])

    def slopes(x: np.ndarray) -> np.ndarray:
        by_length = np.asarray(chord_slopes(ground.looks, at(x)).sum(axis=0)).ravel()[:-2]
        parts = []
        for limit in ground.limits(at(x)):
            if not _is_length(limit):
                slope = limit.slope(np.arange(len(limit.value))).toarray()
                parts.append(slope[:, :-2] + np.outer(slope[:, -1], by_length))
        return np.vstack(parts)

    return NonlinearConstraint(values, low, high, jac=slopes)


def _is_length(limit: Limit) -> bool:
    return len(limit.value) == 1 and limit.low[0] == limit.high[0] == limit.value[0] == 0.0
