"""Where in a list of values, each milder than the one before, routes begin to exist."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from pipeline.route.diagnosis.relaxed_table import SearchOutcome

_TRIES = 12
"""Most whole searches per limit."""


@dataclass(frozen=True)
class FeasibilityThreshold:
    """Where in a list of values routes begin to exist, as far as it is known.

    Attributes
    ----------
    refused : int
        The last value proven not to be enough.
    by_graph : bool
        That the graph alone proves it.
    opened : int or None
        The first value a route was found with, `objective` its sum of kappa, and
    obstruction : str
        how what was removed would be in its way.
    """

    refused: int
    by_graph: bool
    opened: int | None = None
    objective: float | None = None
    obstruction: str = ""


def find_threshold(
    known: FeasibilityThreshold, first: int, end: int, attempt: Callable[[int], SearchOutcome], tries: int = _TRIES
) -> FeasibilityThreshold:
    """Find the first of the values `first` to `end` - 1 that opens: it, then the last, then by bisection.

    Each route found points at the value that is enough for it, as far as its regions go: that one is tried next.
    """
    low, threshold, candidate = first - 1, known, first
    for _ in range(tries):
        if threshold.opened is not None and threshold.opened - low <= 1:
            break
        result = attempt(candidate)
        if result.objective is not None:
            threshold = replace(threshold, opened=candidate, objective=result.objective, obstruction=result.obstruction)
        else:
            low = candidate
            threshold = replace(threshold, refused=low, by_graph=False) if result.proven else threshold
        if threshold.opened is None:
            if low == end - 1:
                break
            candidate = end - 1
        elif result.enough is not None and low < result.enough < threshold.opened:
            candidate = result.enough
        else:
            candidate = (low + threshold.opened) // 2
    return threshold
