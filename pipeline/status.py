"""How a solver ended: one vocabulary for all solvers."""

from enum import StrEnum


class Status(StrEnum):
    """How a stage's solver ended; `advice` says what a user can do next."""

    OPTIMAL = "optimal"
    CONVERGED = "converged"
    UNPROVEN = "not proven optimal"
    INFEASIBLE = "infeasible"
    TIME_LIMIT = "time limit"
    NOT_CONVERGED = "not converged"

    @property
    def solved(self) -> bool:
        """True when the result may be used by the next stage."""
        return self in (Status.OPTIMAL, Status.CONVERGED)

    @property
    def advice(self) -> str:
        """What to do next, in one sentence."""
        return _ADVICE[self]


_ADVICE = {
    Status.OPTIMAL: "Nothing: the result is proven optimal.",
    Status.CONVERGED: "Nothing: all constraints hold to the solver's tolerance.",
    Status.UNPROVEN: "Raise the time limit for a proof, or use the result as it is: it keeps all constraints.",
    Status.INFEASIBLE: "Allow more: tilt, kappa, step budget, travel per step, or a finer grid.",
    Status.TIME_LIMIT: "Raise the time limit, or coarsen the grid or the mesh.",
    Status.NOT_CONVERGED: "Widen the corridor, give more coefficients or iterations, or start from another route.",
}
