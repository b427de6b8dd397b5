"""IPOPT, called through CasADi: it reports every iteration, and Ctrl-C ends the solve and nothing else."""

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from pipeline.solvers.interrupts import interrupts_noted

Iteration = Callable[[int, float], None]
"""Receives the number of an iteration, from one, and the objective there."""


class _Watch(ca.Callback):
    """Reports every iteration to the listener, and stops IPOPT once the user has interrupted."""

    def __init__(self, problem: Mapping[str, ca.MX], listener: Iteration, interrupted: threading.Event) -> None:
        ca.Callback.__init__(self)
        self._sizes = {"x": problem["x"].numel(), "g": problem["g"].numel()}
        self._sizes |= {"lam_x": self._sizes["x"], "lam_g": self._sizes["g"], "f": 1, "lam_p": 0}
        self._listener, self._count, self._interrupted = listener, 0, interrupted
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
        self._listener(self._count, float(arguments[1]))
        return [int(self._interrupted.is_set())]


def run_ipopt(
    name: str,
    problem: Mapping[str, ca.MX],
    options: Mapping[str, Any],
    bounds_and_start: Mapping[str, Any],
    listener: Iteration,
) -> tuple[dict[str, ca.DM], dict[str, Any]]:
    """Solve a nonlinear program with IPOPT and MUMPS; a failed solve does not raise but shows in the statistics.

    Parameters
    ----------
    problem : mapping
        Unknowns x, objective f and constraints g, as CasADi takes them.
    options : mapping
        CasADi's options; those of IPOPT itself under "ipopt".
    bounds_and_start : mapping
        x0, lbx, ubx, lbg, ubg.

    Returns
    -------
    (mapping, mapping)
        Where IPOPT ended (x, f, g and multipliers), and its statistics (`return_status`, `iter_count` ...).

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    ipopt = {"linear_solver": "mumps", "sb": "yes", **options.get("ipopt", {})}
    with interrupts_noted() as interrupted:
        watch = _Watch(problem, listener, interrupted)
        whole = {"print_time": False, "error_on_fail": False, **options, "iteration_callback": watch, "ipopt": ipopt}
        solver = ca.nlpsol(name, "ipopt", dict(problem), whole)
        result = solver(**bounds_and_start)
    return result, solver.stats()
