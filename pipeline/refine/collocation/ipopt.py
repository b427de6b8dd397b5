"""Solving the program of stage two with IPOPT: options, progress, and which constraints are violated at the end."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET, Monitor
from pipeline.refine.collocation.program import Program
from pipeline.solvers import run_ipopt
from pipeline.status import Status

_STATUS = {
    "Solve_Succeeded": Status.CONVERGED,
    "Solved_To_Acceptable_Level": Status.CONVERGED,
    "Maximum_WallTime_Exceeded": Status.TIME_LIMIT,
}
Accuracy = Literal["rough", "timed", "resumed", "precise"]
"""Good enough to start another solve from, to a millionth (the same from a solution on another mesh), or as good as it
gets."""
# Starts are near, and bounds that they keep need not be left first.
_NEAR_BOUNDS: dict[str, float | str] = {"bound_push": 1e-4, "bound_frac": 1e-4}
_TIMED: dict[str, float | str] = {
    "tol": 1e-6,
    "constr_viol_tol": 1e-9,
    "acceptable_tol": 1e-4,
    "acceptable_constr_viol_tol": 1e-9,
    "acceptable_obj_change_tol": 1e-6,
    # It starts from a motion that nearly keeps all limits, and must not be driven far away from them.
    "mu_strategy": "monotone",
    "mu_init": 1e-4,
    **_NEAR_BOUNDS,
}
_TOLERANCES: dict[Accuracy, dict[str, float | str]] = {
    "rough": {"tol": 0.1, "constr_viol_tol": 1e-2, "dual_inf_tol": 1e3, "compl_inf_tol": 0.1, **_NEAR_BOUNDS},
    "timed": _TIMED,
    "resumed": {**_TIMED, "mu_init": 1e-5},
    "precise": {"tol": 1e-7, "constr_viol_tol": 1e-9, "acceptable_constr_viol_tol": 1e-9},
}


_NAMED, _VIOLATED = 3, 1e-9
"""How many groups of violated constraints a failure names at most, and from which violation on."""


@dataclass(frozen=True)
class IpoptOptions:
    """When IPOPT stops."""

    max_iterations: int
    time_limit_s: float
    accuracy: Accuracy = "precise"


@dataclass(frozen=True, eq=False)
class IpoptResult:
    """Where IPOPT ended: the unknowns x, and the largest violation of each named group of constraints."""

    status: Status
    message: str
    x: FloatArray
    iterations: int
    violations: dict[str, float]


def solve_program(program: Program, options: IpoptOptions, label: str, monitor: Monitor = QUIET) -> IpoptResult:
    """Solve with IPOPT and MUMPS from the program's guess; never raises for a failed solve, which the status reports.

    Parameters
    ----------
    label : str
        What progress messages begin with.

    Raises
    ------
    KeyboardInterrupt
        If the user interrupts.
    """
    solver_options: dict[str, Any] = {
        **program.derivatives,
        "no_nlp_grad": True,
        "ipopt": {
            "max_iter": options.max_iterations,
            "max_wall_time": options.time_limit_s,
            "print_level": 5 if monitor.verbose else 0,
            "mu_strategy": "adaptive",
            **_TOLERANCES[options.accuracy],
            # Bounds are promises to a machine: IPOPT must not relax them.
            "bound_relax_factor": 0.0,
        },
    }
    (lbx, ubx), (lbg, ubg) = program.variable_bounds, program.constraint_bounds

    def report(iteration: int, objective: float) -> None:
        monitor.progress(f"{label}: IPOPT iteration {iteration}, objective {objective:.2f}")

    given = {"x0": program.guess, "lbx": lbx, "ubx": ubx, "lbg": lbg, "ubg": ubg}
    result, stats = run_ipopt("refine", program.problem, solver_options, given, report)
    message = str(stats["return_status"])
    return IpoptResult(
        status=_STATUS.get(message, Status.NOT_CONVERGED),
        message=message,
        x=np.array(result["x"]).ravel(),
        iterations=int(stats["iter_count"]),
        violations=_violations(program, np.array(result["g"]).ravel()),
    )


def _violations(program: Program, g: FloatArray) -> dict[str, float]:
    low, high = program.constraint_bounds
    excess = np.maximum(np.maximum(low - g, g - high), 0.0)
    return {block.name: float(excess[block.begin : block.end].max(initial=0.0)) for block in program.blocks}


def ipopt_failure(result: IpoptResult, arrays: dict[str, object]) -> NoSolutionError:
    """Say how IPOPT failed, and what is violated; `arrays` are those of the last path."""
    worst = sorted(result.violations.items(), key=lambda item: -item[1])[:_NAMED]
    broken = ", ".join(f"{name} by {value:.2e}" for name, value in worst if value > _VIOLATED)
    state = f"most violated: {broken}" if broken else "all constraints hold, but kappa can still be lowered"
    return NoSolutionError(
        "refine",
        f"IPOPT ended with {result.message} after {result.iterations} iterations; {state}",
        result.status.advice,
        {
            "status": result.status.value,
            "message": result.message,
            "violations": result.violations,
            **arrays,
        },
    )
