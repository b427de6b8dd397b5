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
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.symbolic import statics_function
from pipeline.refine.collocation.program import Program
from pipeline.refine.corridor.cells import visit_parameters
from pipeline.refine.integral.minimise import guess_from, program_data
from pipeline.refine.integral.program import build_program
from pipeline.refine.mesh import even_mesh
from pipeline.refine.peak.constraints import Constraint, by_unknowns
from pipeline.refine.peak.iterate import Iterate, iterate_at
from pipeline.refine.peak.lower import peak_problem
from pipeline.refine.peak.problem import PeakProblem
from pipeline.refine.peak.speed import chord_slopes
from pipeline.refine.peak.step import integral_slope
from pipeline.refine.problem import FROBENIUS, MeshSolution, Problem, build_problem, fit_coarse
from pipeline.refine.splines import basis
from pipeline.route import build_regions, plan_route

EVENNESS = 10.0
SOLVERS: dict[str, dict[str, Any]] = {
    "ipopt": {"ipopt": {"linear_solver": "mumps", "print_level": 0, "sb": "yes", "tol": 1e-5, "max_iter": 3_000}},
    "uno": {"uno": {"logger": "SILENT"}},
    "fatrop": {"structure_detection": "none", "fatrop": {"print_level": 0, "max_iter": 3_000}},
    "madnlp": {"madnlp": {"print_level": 6}},
}


def problem_of(config: Config) -> Problem:
    """Plan the route that is refined."""
    machine = build_machine(config.machine)
    return build_problem(config, machine, plan_route(config, machine, build_regions(config, machine)))


def first_fit(problem: Problem, nodes: int, coefficients: int) -> MeshSolution:
    """Fit splines to the coarse path on an even mesh."""
    return fit_coarse(problem, even_mesh(nodes, coefficients, visit_parameters(problem.coarse, problem.route)))


def solve_program(config: Config, nodes: int, coefficients: int, solver: str, lifted: bool) -> Iterator[dict[str, Any]]:
    """Solve the written-out program with a solver of CasADi, actuators lifted or replaced by the splines."""
    problem = problem_of(config)
    initial = first_fit(problem, nodes, coefficients)
    begun = time.perf_counter()
    program = build_program(program_data(problem, initial, FROBENIUS, EVENNESS), guess_from(initial))
    written, bounds, x0 = _written_out(program, problem, initial), _bounds(program), program.guess
    if not lifted:
        written, bounds, x0 = _in_place(program, initial, written)
    try:
        solver_function = ca.nlpsol(
            "peer", solver, written, {"error_on_fail": False, "print_time": False, **SOLVERS[solver]}
        )
    except RuntimeError as error:
        yield {"outcome": "not in this wheel" if "not found" in str(error) else "failed to build"}
        return
    yield {"build_s": time.perf_counter() - begun, "unknowns": len(x0), "outcome": "not solved in the limit"}
    begun = time.perf_counter()
    result = solver_function(x0=x0, lbx=bounds[0], ubx=bounds[1], lbg=bounds[2], ubg=bounds[3])
    stats = solver_function.stats()
    yield {
        "solve_s": time.perf_counter() - begun,
        "iterations": stats.get("iter_count"),
        "objective": float(result["f"]),
        "outcome": "solved" if stats["success"] else str(stats.get("return_status", "failed")),
    }


def _bounds(program: Program) -> tuple[np.ndarray, ...]:
    return (*program.variable_bounds, *program.constraint_bounds)


def _written_out(program: Program, problem: Problem, initial: MeshSolution) -> dict[str, ca.MX]:
    """Replace the kappa with derivatives of its own by one that CasADi differentiates."""
    x, k = program.problem["x"], program.nodes
    pose, q = ca.reshape(x[: 6 * k], 6, k), ca.reshape(x[6 * k : 11 * k], 5, k)
    distance = ca.sqrt(
        ca.sum1(((pose[list(CONTROLLED), 1:] - pose[list(CONTROLLED), :-1]) / problem.steps) ** 2) + 1e-8
    )
    kappa = _frobenius(problem).map(k)(pose, q)
    length = x[-1]
    deviation = distance / ca.DM(np.diff(initial.mesh.s)).T - length
    uneven = ca.dot(ca.DM(np.diff(initial.mesh.s)).T, deviation**2) / problem.length
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
    program: Program, initial: MeshSolution, written: dict[str, ca.MX]
) -> tuple[dict[str, ca.MX], tuple[np.ndarray, ...], np.ndarray]:
    """Replace the actuators of nodes by basis @ coefficients, and drop the equations that tied them."""
    k, x0 = program.nodes, program.guess
    keep = np.r_[: 6 * k, 11 * k : len(x0)]
    x = ca.MX.sym("x", len(keep))
    c = ca.reshape(x[6 * k : 6 * k + 5 * program.coefficients], 5, program.coefficients)
    q = c @ ca.DM(basis(initial.mesh.knots, initial.mesh.s).toarray()).T
    both = ca.Function("both", [written["x"]], [written["f"], written["g"]])
    f, g = both.call([ca.vertcat(x[: 6 * k], ca.vec(q), x[6 * k :])], True, False)
    tied = next(block for block in program.blocks if block.name == "spline")
    rows = np.r_[: tied.begin, tied.end : g.numel()]
    low, high, g_low, g_high = _bounds(program)
    problem = {"x": x, "f": f, "g": g[rows.tolist()]}
    return problem, (low[keep], high[keep], g_low[rows], g_high[rows]), x0[keep]


def solve_with_scipy(config: Config, nodes: int, coefficients: int, method: str) -> Iterator[dict[str, Any]]:
    """Minimise the integral of kappa over the coefficients alone, with constraints and slopes of the descent."""
    problem = problem_of(config)
    found = peak_problem(problem, first_fit(problem, nodes, coefficients))
    assert found is not None
    peak, first = found
    known: dict[bytes, Iterate] = {}

    def at(x: np.ndarray) -> Iterate:
        if x.tobytes() not in known:
            known.clear()
            known[x.tobytes()] = iterate_at(peak.points, x.reshape(-1, 5), first.samples.pose) or first
        return known[x.tobytes()]

    low, high = np.tile(peak.actuator_range_m.T, (1, coefficients))
    x0 = first.coefficients.ravel()
    low[:5] = high[:5] = x0[:5]
    low[-5:] = high[-5:] = x0[-5:]
    yield {"unknowns": len(x0), "outcome": "not solved in the limit"}
    begun = time.perf_counter()
    result = minimize(
        lambda x: at(x).integral,
        np.clip(x0, low, high),
        jac=lambda x: _integral_slope(peak, at(x)),
        method=method,
        bounds=Bounds(low, high),
        constraints=[_constraint(peak, at, first)],
        options={"maxiter": 3_000},
    )
    yield {
        "solve_s": time.perf_counter() - begun,
        "iterations": int(result.nit),
        "objective": float(result.fun),
        "outcome": "solved" if result.success else str(result.message),
    }


def _integral_slope(peak: PeakProblem, iterate: Iterate) -> np.ndarray:
    points = peak.points
    kappa_slope = by_unknowns(points, np.arange(len(points.s)), iterate.kappa_slope)
    return integral_slope(points, iterate, kappa_slope)[:-2]


def _constraint(peak: PeakProblem, at: Callable[[np.ndarray], Iterate], first: Iterate) -> NonlinearConstraint:
    """Join all constraints; what they require of the length is expressed by the coefficients."""
    rows = [part for part in peak.constraints(first) if not _is_length(part)]
    low, high = (np.concatenate([getattr(part, side) for part in rows]) for side in ("low", "high"))

    def values(x: np.ndarray) -> np.ndarray:
        return np.concatenate([part.value for part in peak.constraints(at(x)) if not _is_length(part)])

    def slopes(x: np.ndarray) -> np.ndarray:
        by_length = np.asarray(chord_slopes(peak.points, at(x)).sum(axis=0)).ravel()[:-2]
        parts = []
        for part in peak.constraints(at(x)):
            if not _is_length(part):
                slope = part.slope(np.arange(len(part.value))).toarray()
                parts.append(slope[:, :-2] + np.outer(slope[:, -1], by_length))
        return np.vstack(parts)

    return NonlinearConstraint(values, low, high, jac=slopes)


def _is_length(part: Constraint) -> bool:
    return len(part.value) == 1 and part.low[0] == part.high[0] == part.value[0] == 0.0
