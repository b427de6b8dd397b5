"""Lowering the largest kappa as far as the objective asks for, on the mesh of a solution."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline

from pipeline.errors import NoSolutionError
from pipeline.limits import counting, node_limits
from pipeline.limits.actuator_margins import planned_range_m
from pipeline.limits.kappa import path_cap
from pipeline.refine.corridor.cells import corridor
from pipeline.refine.mesh import midpoints
from pipeline.refine.objective import TIE_BREAK
from pipeline.refine.one_way import one_way_legs
from pipeline.refine.peak.constraints import PathConstraints, least_values
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, iterate_at
from pipeline.refine.peak.problem import PeakObjective, PeakProblem
from pipeline.refine.peak.sqp import Descent, descend
from pipeline.refine.problem import SCHATTEN, MeshSolution, Problem
from pipeline.refine.result import Path, directions_of
from pipeline.refine.splines import DEGREE
from pipeline.status import Status

_BELOW_COARSE = 0.97
"""Share of the coarse path's largest kappa that an objective which improves on it aims at: peaks shall fall."""
_ABOVE_LEAST = 1.1
"""How far above the least largest kappa of regions that aim may be at most: going farther down costs more of the
integral than it brings, and between regions kappa is a few per cent larger than at them."""
_BELOW_CAP = 0.995
"""Share of the cap that counts as it: between two points kappa may be a little higher than at them."""


def lower_peak(problem: Problem, initial: MeshSolution) -> MeshSolution:
    """Lower what the objective asks for, the largest kappa included, starting from the path of a solution.

    kappa and limits are evaluated at the nodes and half-way between them. Start and goal are given, and their kappa.

    Raises
    ------
    NoSolutionError
        If `refine.max_iterations` steps were not enough; the last path is in the `diagnosis`.
    """
    found = peak_problem(problem, initial)
    if found is None:
        return initial
    peak, iterate = found
    target, cap = _target_and_cap(problem, iterate)
    row, most = problem.objective, problem.config.refine.max_iterations
    smoothness = problem.smoothness.form(initial.mesh.knots)
    objective = PeakObjective(row.mean_weight, row.peak_weight, target, cap, problem.length, smoothness)
    problem.monitor.progress(
        f"refine: {len(initial.mesh.s)} nodes: lowering the largest kappa, now {iterate.kappa.max():.2f}"
    )
    solution = initial
    if iterate.kappa.max() > cap:
        # What is above its cap comes below it first, and the rest counts afterwards.
        below = replace(objective, mean_weight=TIE_BREAK, target=cap, cap=np.inf)
        first = descend(peak, below, iterate, most)
        solution, iterate = _solution_of(problem, peak, solution, first), first.iterate
        objective = replace(objective, cap=max(cap, float(iterate.kappa.max())))
    return _solution_of(problem, peak, solution, descend(peak, objective, iterate, most))


def peak_problem(problem: Problem, initial: MeshSolution) -> tuple[PeakProblem, Iterate] | None:
    """Build the problem of a descent and its first iterate; None if the path of the solution cannot be evaluated."""
    config, machine = problem.config, problem.machine
    # A point at every node, and one between every two.
    s = np.union1d(initial.mesh.s, midpoints(initial.mesh.s))
    points = EvaluationPoints(machine, s, initial.mesh.knots, problem.steps, SCHATTEN)
    iterate = iterate_at(points, initial.path.spline.c, initial.path.pose(s))
    if iterate is None:
        return None
    limits = node_limits(config, machine)
    margin, directions = config.refine.clearance_margin_m, directions_of(initial.path.q(s, 1))
    required = PathConstraints(
        corridor=corridor(config, problem.route, problem.coarse, s),
        limits=[
            least_values(
                limit,
                limit.values(iterate.samples),
                limit.node_margin(margin),
                counting(limit, iterate.samples, directions),
            )
            for limit in limits
        ],
    )
    one_way = one_way_legs(limits, iterate.samples, s, initial.mesh.knots)
    range_m = planned_range_m(config, machine)
    return PeakProblem(points, required, problem.directions, range_m, one_way), iterate


def _target_and_cap(problem: Problem, iterate: Iterate) -> tuple[float, float]:
    """Choose the target of the largest kappa and its cap: neither is below that of the start or the goal."""
    ends = float(max(iterate.kappa[0], iterate.kappa[-1]))
    cap = _BELOW_CAP * path_cap(problem.config)
    if not problem.objective.improves_on_coarse:
        return ends, max(cap, ends)
    coarse, least = problem.coarse_kappa_max, problem.route.search.least_kappa_max
    return max(min(_BELOW_COARSE * coarse, _ABOVE_LEAST * least, cap), ends), max(min(coarse, cap), ends)


def _solution_of(problem: Problem, peak: PeakProblem, initial: MeshSolution, descent: Descent) -> MeshSolution:
    spline = BSpline(initial.mesh.knots, descent.iterate.coefficients, DEGREE)
    path = Path(problem.machine, spline, peak.points.s, descent.iterate.samples.pose)
    iterations = initial.iterations + descent.steps
    solution = MeshSolution(initial.mesh, path, descent.iterate.integral, iterations)
    if not descent.converged:
        raise NoSolutionError(
            "refine",
            f"kappa was still falling after {descent.steps} steps",
            "Raise refine.max_iterations.",
            {"status": Status.NOT_CONVERGED.value, **solution.arrays},
        )
    return solution
