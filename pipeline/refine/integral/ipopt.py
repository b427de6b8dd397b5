"""Solving the program of stage two with IPOPT: options, progress, and which constraints are violated at the end."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.progress import QUIET, Monitor
from pipeline.refine.integral.program import Program
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
_TIMED: dict[str, float | str] = {
    "tol": 1e-6,
    "constr_viol_tol": 1e-9,
    "acceptable_tol": 1e-4,
    "acceptable_constr_viol_tol": 1e-9,
    "acceptable_obj_change_tol": 1e-6,
    # It starts from a motion that nearly keeps all limits, and must not be driven far away from them.
    "mu_strategy": "monotone",
    "mu_init": 1e-4,
    "bound_push": 1e-4,
    "bound_frac": 1e-4,
}
_TOLERANCES: dict[Accuracy, dict[str, float | str]] = {
    "rough": {"tol": 0.1, "constr_viol_tol": 1e-2, "dual_inf_tol": 1e3, "compl_inf_tol": 0.1},
    "timed": _TIMED,
    "resumed": {**_TIMED, "mu_init": 1e-5},
    "precise": {"tol": 1e-7, "constr_viol_tol": 1e-9, "acceptable_constr_viol_tol": 1e-9},
}


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
