"""How long limiting jerk tries before it gives up."""

from dataclasses import dataclass


@dataclass(frozen=True)
class JerkOptions:
    """How jerk is limited; the defaults suit all tasks.

    Attributes
    ----------
    pieces_per_width : float
        Least number of pieces within the width of an average of the first guess, where acceleration changes.
    rounds : int
        Programs solved at most, each with the limits checked at more points.
    iterations : int
        Iterations of IPOPT for one program at most.
    all_iterations : int
        Iterations of all programs after which there is no further round.
    most_ramps : float
        Times that accelerations could build up within the motion, at most; beyond it jerk limits are lowered. What this
        costs is below a thousandth of the duration, and such short ramps would take a program very long.
    slowdowns : tuple of float
        Factors by which the start of a program is slowed down, one after the other, until the program is solved.
    """

    pieces_per_width: float = 3.0
    rounds: int = 12
    iterations: int = 500
    all_iterations: int = 1_500
    most_ramps: float = 2_000.0
    slowdowns: tuple[float, ...] = (1.0, 2.0, 5.0)


DEFAULTS = JerkOptions()
