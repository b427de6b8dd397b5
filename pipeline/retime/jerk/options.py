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
    slowdowns : tuple of float
        Factors by which the start of a program is slowed down, one after the other, until the program is solved.
    """

    pieces_per_width: float = 3.0
    rounds: int = 12
    iterations: int = 500
    slowdowns: tuple[float, ...] = (1.0, 2.0, 5.0)


DEFAULTS = JerkOptions()
