"""Running IPOPT: options, progress, interruption, and which constraints are violated where it ends."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any, Literal

import casadi as ca
import numpy as np

from pipeline.machine.geometry import FloatArray
from pipeline.progress import Progress
from pipeline.refine.nlp import Program
from pipeline.status import Status

_STATUS = {
    "Solve_Succeeded": Status.CONVERGED,
    "Solved_To_Acceptable_Level": Status.CONVERGED,
    "Maximum_WallTime_Exceeded": Status.TIME_LIMIT,
}
_PRECISE = {"tol": 1e-7, "constr_viol_tol": 1e-9, "acceptable_constr_viol_tol": 1e-9}
_ROUGH = {"tol": 0.1, "constr_viol_tol": 1e-2, "dual_inf_tol": 1e3, "compl_inf_tol": 0.1}

Manner = Literal["rough", "precise"]
"""Good enough to start another solve from, or as good as it gets."""
_MANNERS: dict[Manner, dict[str, float]] = {"rough": _ROUGH, "precise": _PRECISE}


@dataclass(frozen=True, eq=False)
class Solution:
    """Where IPOPT ended: the unknowns, and the largest violation per named group of constraints."""

    status: Status
    message: str
    x: FloatArray
    iterations: int
    violations: dict[str, float]


class _Watch(ca.Callback):
    """Tells the listener about every iteration, and stops IPOPT once `interrupted` is set."""

    def __init__(self, program: Program, progress: Progress, what: str) -> None:
        ca.Callback.__init__(self)
        self._sizes = {"x": program.problem["x"].numel(), "g": program.problem["g"].numel()}
        self._sizes |= {"lam_x": self._sizes["x"], "lam_g": self._sizes["g"], "f": 1, "lam_p": 0}
        self._progress, self._what, self._count = progress, what, 0
        self.interrupted = threading.Event()
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(ca.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[ca.nlpsol_out(i)], 1)

    def eval(self, arguments: Sequence[ca.DM]) -> list[int]:
        self._count += 1
        self._progress(f"{self._what}: IPOPT iteration {self._count}, objective {float(arguments[1]):.2f}")
        return [int(self.interrupted.is_set())]


def solve_program(
    program: Program,
    max_iterations: int,
    time_limit_s: float,
    progress: Progress,
    what: str,
    verbose: bool = False,
    manner: Manner = "precise",
) -> Solution:
    """Solve with IPOPT and MUMPS from the program's start; never raises for a failed solve, the status tells.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    watch = _Watch(program, progress, what)
    options: dict[str, Any] = {
        "iteration_callback": watch,
        "print_time": False,
        "error_on_fail": False,
        **program.derivatives,
        "no_nlp_grad": True,
        "ipopt": {
            "linear_solver": "mumps",
            "max_iter": max_iterations,
            "max_wall_time": time_limit_s,
            "print_level": 5 if verbose else 0,
            "sb": "yes",
            "mu_strategy": "adaptive",
            **_MANNERS[manner],
            # Bounds are promises to a machine: IPOPT must not relax them.
            "bound_relax_factor": 0.0,
        },
    }
    solver = ca.nlpsol("refine", "ipopt", program.problem, options)
    low, high = program.variable_bounds
    with _interrupts_noted(watch.interrupted):
        result = solver(
            x0=program.start, lbx=low, ubx=high, lbg=program.constraint_bounds[0], ubg=program.constraint_bounds[1]
        )
    if watch.interrupted.is_set():
        raise KeyboardInterrupt
    stats = solver.stats()
    message = str(stats["return_status"])
    return Solution(
        status=_STATUS.get(message, Status.NOT_CONVERGED),
        message=message,
        x=np.array(result["x"]).ravel(),
        iterations=int(stats["iter_count"]),
        violations=_violations(program, np.array(result["g"]).ravel()),
    )


@contextmanager
def _interrupts_noted(interrupted: threading.Event) -> Iterator[None]:
    """Note Ctrl-C instead of raising: CasADi would swallow the exception and report a failed solve.

    Signals only ever reach the main thread; elsewhere there is nothing to note.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def note(_signal: int, _frame: FrameType | None) -> None:
        interrupted.set()

    before = signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _violations(program: Program, g: FloatArray) -> dict[str, float]:
    low, high = program.constraint_bounds
    excess = np.maximum(np.maximum(low - g, g - high), 0.0)
    return {block.name: float(excess[block.begin : block.end].max(initial=0.0)) for block in program.blocks}
