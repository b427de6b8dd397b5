"""How far outside a box of controlled poses everything is that a proven box holds."""

from heapq import heappop, heappush

import numpy as np
from flint import arb, arb_poly

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import below
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.pose import CONTROLLED

_MOST_HALVINGS = 7
_SHARP = 1e-4
"""Parts are not halved for less than this, in metres or radians, nor for less than this share of the bound itself."""

_Side = tuple[arb_poly, arb]
"""How far beyond a side the centre is, as a polynomial in t, and how far poses are from the centre."""


def least_outside(box: ProvenBox, low: FloatArray, high: FloatArray) -> float:
    """Bound from below how far poses are outside of low to high, both (5,), for all errors of the actuators.

    Outside is whoever is beyond one side: with x(t) + P a the centre, r its distance from the poses, and 2^k parts of
    the interval about m with half-width d,

        min over t  max over sides  (sign (x(t) - side) - |P| A - r),

    each side's polynomial f being at least f(m) - sum |f_n(m)| d^n over a part. The part with the least bound is halved
    as long as that may show more. The bound is in metres or radians, negative if the box may be entered.
    """
    sides, half = _sides(box, low, high), box.series.half
    if not sides:
        return -np.inf
    waiting = list[tuple[float, int, int]]()
    attained = min(_part_bound(sides, end, arb(0))[1] for end in (-half, half))

    def add(k: int, halvings: int) -> None:
        nonlocal attained
        part = half / 2**halvings
        least, middle = _part_bound(sides, part * (2 * k + 1) - half, part)
        attained = min(attained, middle)
        heappush(waiting, (least, halvings, k))

    add(0, 0)
    while True:
        least, halvings, k = heappop(waiting)
        if halvings == _MOST_HALVINGS or attained - least <= _SHARP * max(1.0, attained) or not half > 0:
            return least
        add(2 * k, halvings + 1)
        add(2 * k + 1, halvings + 1)


def _sides(box: ProvenBox, low: FloatArray, high: FloatArray) -> list[_Side]:
    moved, found = box.inclusion.following.moved, list[_Side]()
    for column, *ends in zip(CONTROLLED.tolist(), low.tolist(), high.tolist(), strict=True):
        reach = (box.displacement.pose[column].abs_upper() + moved[column].abs_upper()).upper()
        for end, sign in zip(ends, (-1, 1), strict=True):
            if np.isfinite(end):
                first, *others = [arb(value) for value in box.inclusion.box.pose[:, column].tolist()]
                found.append((arb_poly([first - arb(end), *others]) * sign, reach))
    return found


def _part_bound(sides: list[_Side], middle: arb, part: arb) -> tuple[float, float]:
    """Bound how far outside the poses of a part are from below, and how far they are in its middle from above."""
    least, attained = -np.inf, -np.inf
    for polynomial, reach in sides:
        value, *slopes = polynomial(arb_poly([middle, arb(1)])).coeffs() or [arb(0)]
        spread = sum((slope.abs_upper() * part**n for n, slope in enumerate(slopes, start=1)), arb(0))
        least = max(least, below(value - spread - reach))
        attained = max(attained, below(value - reach))
    return least, attained
