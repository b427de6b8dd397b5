"""Running solvers that more than one stage uses."""

from pipeline.solvers.interrupts import interrupts_noted
from pipeline.solvers.ipopt import Iteration, run_ipopt

__all__ = ["Iteration", "interrupts_noted", "run_ipopt"]
