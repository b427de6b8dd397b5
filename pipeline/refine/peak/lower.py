"""Bringing the largest kappa down as far as the objective asks for, on the mesh of a solve."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline

from pipeline.errors import NoSolutionError
from pipeline.limits.kappa import path_cap
from pipeline.machine.clearance import link_distances, link_rail_distances
from pipeline.refine.corridor import corridor
from pipeline.refine.mesh import midpoints
from pipeline.refine.peak.constraints import PathConstraints, least_distances
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, iterate_at
from pipeline.refine.peak.sqp import Descent, PeakObjective, PeakProblem, descend
from pipeline.refine.result import Path
from pipeline.refine.solve import SCHATTEN, MeshSolution, Problem
from pipeline.refine.splines import DEGREE
from pipeline.status import Status

_WEIGHTS = {"integral": (1.0, 1.0), "mixed": (1.0, 1.0), "maximum": (0.01, 1.0)}
"""Of the mean of kappa and of its largest value above what is aimed at; a hundredth settles what the largest leaves."""
_AIM = 0.97
"""Share of the coarse path's largest kappa that the integral's objective aims at, too: peaks are to come down."""
_BELOW_CAP = 0.995
"""Share of the cap that counts as it: between two looks kappa may be a little higher than at them."""


def lower_peak(problem: Problem, solve: MeshSolution) -> MeshSolution:
    """Lower what the objective asks for from a solve's path on, largest kappa included.

    kappa and limits are looked at in the nodes and half-way between them. Start and goal are given, and their kappa.

    Raises
    ------
    NoSolutionError
        When `refine.max_iterations` steps were not enough; the last path is in its `diagnosis`.
    """
    found = peak_problem(problem, solve)
    if found is None:
        return solve
    ground, iterate = found
    aim, cap = _aim_and_cap(problem, iterate)
    mean, largest = _WEIGHTS[problem.config.refine.objective]
    wish = PeakObjective(mean, largest, aim, cap, problem.length)
    problem.progress(f"refine ({len(solve.mesh.s)} nodes): largest kappa {iterate.kappa.max():.2f}, going down")
    most = problem.config.refine.max_iterations
    if iterate.kappa.max() > cap:
        # What is above its cap comes below it first, and the rest counts afterwards.
        first = descend(ground, replace(wish, mean=_WEIGHTS["maximum"][0], aim=cap, cap=np.inf), iterate, most)
        solve = _solve_of(problem, ground, solve, first)
        iterate = first.iterate
        wish = replace(wish, cap=max(cap, float(iterate.kappa.max())))
    return _solve_of(problem, ground, solve, descend(ground, wish, iterate, most))


def _solve_of(problem: Problem, ground: PeakProblem, begun: MeshSolution, descent: Descent) -> MeshSolution:
    spline = BSpline(begun.mesh.knots, descent.iterate.coefficients, DEGREE)
    path = Path(problem.machine, spline, ground.looks.s, descent.iterate.pose)
    solve = MeshSolution(begun.mesh, path, descent.iterate.integral, begun.iterations + descent.steps)
    if not descent.converged:
        raise NoSolutionError(
            "refine",
            f"kappa was still going down after {descent.steps} steps",
            "Raise refine.max_iterations.",
            {"status": Status.NOT_CONVERGED.value, **solve.arrays},
        )
    return solve


def peak_problem(problem: Problem, solve: MeshSolution) -> tuple[PeakProblem, Iterate] | None:
    """Say where a descent from a solve's path looks, what it has to keep, and where it begins; None: it cannot."""
    config, machine = problem.config, problem.machine
    # A look in every node, and one between every two.
    s = np.union1d(solve.mesh.s, midpoints(solve.mesh.s))
    looks = EvaluationPoints.at(machine, s, solve.mesh.knots, problem.steps, SCHATTEN)
    iterate = iterate_at(looks, solve.path.spline.c, solve.path.pose(s))
    if iterate is None:
        return None
    pose, carts, margin = iterate.pose, iterate.q_m[:, :3], config.refine.clearance_margin_m
    demands = PathConstraints(
        corridor=corridor(config, problem.route, problem.coarse, s),
        link_m=least_distances(link_distances(machine, pose, carts), machine.link_link_m, margin),
        rail_m=least_distances(link_rail_distances(machine, pose, carts), machine.link_rail_m, margin),
    )
    return PeakProblem(looks, demands, problem.directions, machine.actuator_limits_m), iterate


def _aim_and_cap(problem: Problem, iterate: Iterate) -> tuple[float, float]:
    """What is aimed at for the largest kappa, and its cap: neither below that of the start or the goal.

    For the integral, too, the largest kappa is to be less than on the coarse path, and never more where that can be.
    """
    config, ends = problem.config, float(max(iterate.kappa[0], iterate.kappa[-1]))
    cap = _BELOW_CAP * path_cap(config)
    if config.refine.objective != "integral":
        return ends, max(cap, ends)
    coarse = problem.coarse_kappa_max
    return max(min(_AIM * coarse, cap), ends), max(min(coarse, cap), ends)
