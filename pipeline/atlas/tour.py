"""A short tour through stations: the order in which they are visited."""

from collections.abc import Sequence

from pipeline.arrays import FloatArray

_ROUNDING = 1e-9
_LONGEST_MOVED = 3
"""Stations of a stretch that is moved elsewhere."""


def tour_order(costs: FloatArray, first: int, middle: Sequence[int], last: int) -> list[int]:
    """Order stations between a first and a last one: the nearest next, then improved until nothing helps.

    An improvement reverses a stretch of the tour, or moves one elsewhere (2-opt and Or-opt); costs may depend on the
    direction.

    Parameters
    ----------
    costs : (n, n)
        Of going from one station (row) to another (column); infinite where there is no way.

    Returns
    -------
    list of int
        The stations in the middle, in their order.
    """
    left, tour = list(middle), [first]
    while left:
        nearest = min(left, key=lambda station: (costs[tour[-1], station], station))
        left.remove(nearest)
        tour.append(nearest)
    tour.append(last)
    while (better := _improved(costs, tour)) is not None:
        tour = better
    return tour[1:-1]


def tour_cost(costs: FloatArray, tour: Sequence[int]) -> float:
    """Add up the costs along a tour."""
    return float(costs[list(tour[:-1]), list(tour[1:])].sum())


def _improved(costs: FloatArray, tour: list[int]) -> list[int] | None:
    """Find the first change that makes a tour cheaper; None if there is none."""
    now = tour_cost(costs, tour)
    for i in range(1, len(tour) - 1):
        for j in range(i + 1, len(tour)):
            part, rest = tour[i:j], tour[:i] + tour[j:]
            others = [tour[:i] + part[::-1] + tour[j:]]
            if len(part) <= _LONGEST_MOVED:
                others += [rest[:k] + part + rest[k:] for k in range(1, len(rest))]
            for other in others:
                if tour_cost(costs, other) < now - _ROUNDING:
                    return other
    return None
