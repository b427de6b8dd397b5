"""Solving the program of stage two: options, progress, and which constraints are violated where IPOPT ends."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.progress import Progress
from pipeline.refine.integral.program import Program
from pipeline.solvers import run_ipopt
from pipeline.status import Status

_STATUS = {
    "Solve_Succeeded": Status.CONVERGED,
    "Solved_To_Acceptable_Level": Status.CONVERGED,
    "Maximum_WallTime_Exceeded": Status.TIME_LIMIT,
}
_PRECISE = {"tol": 1e-7, "constr_viol_tol": 1e-9, "acceptable_constr_viol_tol": 1e-9}
_ROUGH = {"tol": 0.1, "constr_viol_tol": 1e-2, "dual_inf_tol": 1e3, "compl_inf_tol": 0.1}

Accuracy = Literal["rough", "precise"]
"""Good enough to start another solve from, or as good as it gets."""
_MANNERS: dict[Accuracy, dict[str, float]] = {"rough": _ROUGH, "precise": _PRECISE}


@dataclass(frozen=True, eq=False)
class Solution:
    """Where IPOPT ended: the unknowns, and the largest violation per named group of constraints."""

    status: Status
    message: str
    x: FloatArray
    iterations: int
    violations: dict[str, float]


def solve_program(
    program: Program,
    max_iterations: int,
    time_limit_s: float,
    progress: Progress,
    what: str,
    verbose: bool = False,
    manner: Accuracy = "precise",
) -> Solution:
    """Solve with IPOPT and MUMPS from the program's start; never raises for a failed solve, the status tells.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    options: dict[str, Any] = {
        **program.derivatives,
        "no_nlp_grad": True,
        "ipopt": {
            "max_iter": max_iterations,
            "max_wall_time": time_limit_s,
            "print_level": 5 if verbose else 0,
            "mu_strategy": "adaptive",
            **_MANNERS[manner],
            # Bounds are promises to a machine: IPOPT must not relax them.
            "bound_relax_factor": 0.0,
        },
    }
    (lbx, ubx), (lbg, ubg) = program.variable_bounds, program.constraint_bounds

    def tell(iteration: int, objective: float) -> None:
        progress(f"{what}: IPOPT iteration {iteration}, objective {objective:.2f}")

    given = {"x0": program.start, "lbx": lbx, "ubx": ubx, "lbg": lbg, "ubg": ubg}
    result, stats = run_ipopt("refine", program.problem, options, given, tell)
    message = str(stats["return_status"])
    return Solution(
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
