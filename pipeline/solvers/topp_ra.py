"""TOPP-RA: the fastest speed profile under rows of linear inequalities on a grid (Pham and Pham, 2018).

In x = sd^2 and with a constant path acceleration u in a cell of width D, x at the end of the cell is y = x + 2 D u.
Rows a u + b x + c <= 1 hold at both ends of each cell. A pass from the goal finds the largest x from which the goal can
still be reached, a pass from the start the largest of these that can be reached. The linear programs of both passes
have two unknowns and are solved in closed form, without a tolerance: there is a profile for all units and ratios of
limits, as long as rest is within the limits (c < 1).
"""

from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray

_FREE = 1e150
"""Replaces a squared path speed without a limit."""
_LEAST_TRADED = 0.25
"""Rows with 0 < a < 2 D b trade y for x; this part of (1 - c) / b is always left to y, so that no motion is stopped by
a fast beginning of a cell."""


class _Cells(NamedTuple):
    """Rows a u + b x <= r of k cells, those of both ends, x at the beginning. Shapes (k, m); widths (k, 1)."""

    a: FloatArray
    b: FloatArray
    r: FloatArray
    width: FloatArray


def fastest_profile(s: FloatArray, rows: tuple[FloatArray, FloatArray, FloatArray], cap: FloatArray) -> FloatArray:
    """Find the fastest speed profile sd(s) from rest to rest, positive in between. Shape (n,).

    Parameters
    ----------
    s : (n,)
        Grid, ascending.
    rows : three (n, m)
        Coefficients of a sdd + b sd^2 + c <= 1.
    cap : (n,)
        Largest sd; may be infinite.

    Raises
    ------
    ValueError
        Where rest is not within the limits.
    """
    if not (rows[2] < 1.0).all():
        raise ValueError("rest is not within the limits: each c has to be below one")
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cells = _cells(s, *rows)
        x = np.append(_largest(cells, _caps(cells, np.minimum(cap**2, _FREE))), 0.0)
        return np.asarray(np.sqrt(_forward(cells, _backward(cells, x))))


def _cells(s: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> _Cells:
    """Write the rows of both ends of each cell in u and x: a u + b (x + 2 D u) = (a + 2 D b) u + b x."""
    width, room = np.diff(s)[:, None], 1.0 - c
    both = ((a[:-1], a[1:] + 2.0 * width * b[1:]), (b[:-1], b[1:]), (room[:-1], room[1:]))
    a, b, r = (np.concatenate(ends, axis=1) for ends in both)
    return _Cells(a, b, r, width)


def _caps(cells: _Cells, cap: FloatArray) -> FloatArray:
    """Lower caps on x (k + 1,) by the rows that limit it alone, and by those that would trade y for it."""
    a, b, r, width = cells
    alone, steep = np.where(b > 0.0, r / b, np.inf), 2.0 * width * b
    traded = np.where((a > 0.0) & (a < steep), alone * (steep - _LEAST_TRADED * a) / (steep - a), np.inf)
    own = np.minimum(np.where(a == 0.0, alone, np.inf), traded).min(axis=1)
    return np.asarray(np.minimum(cap, np.append(own, np.inf)))


def _largest(cells: _Cells, cap: FloatArray) -> FloatArray:
    """Find the largest x at which some u keeps all rows of a cell (Newton's method on the width of its interval).

    The width of the interval of u is a concave function of x, piecewise linear and positive at x = 0: from the right,
    Newton's method ends at its zero after a few steps.
    """
    a, b, r, _ = cells
    up, down = a > 0.0, a < 0.0
    x, n = cap[:-1].copy(), np.arange(len(a))
    while True:
        u = (r - b * x[:, None]) / a
        i, j = np.where(up, u, np.inf).argmin(axis=1), np.where(down, u, -np.inf).argmax(axis=1)
        crossed = up[n, i] & down[n, j] & (u[n, i] < u[n, j])
        rise, fall = a[n, i], -a[n, j]
        zero = (r[n, i] * fall + r[n, j] * rise) / (b[n, i] * fall + b[n, j] * rise)
        better = crossed & (zero < x)
        if not better.any():
            return x
        x = np.where(better, zero, x)


def _backward(cells: _Cells, x: FloatArray) -> FloatArray:
    """Lower x (k + 1,) to the largest values from which the goal can be reached: u >= (r - b x) / a where a < 0."""
    a, b, r, width = cells
    rest = 2.0 * width * b - a
    binding = (a < 0.0) & (rest > 0.0)
    factor = np.where(binding, -a / rest, 0.0)
    offset = np.where(binding, 2.0 * width * r / rest, np.inf)
    reaching = x.copy()
    for k in range(len(a) - 1, -1, -1):
        reaching[k] = min(x[k], (factor[k] * reaching[k + 1] + offset[k]).min())
    return reaching


def _forward(cells: _Cells, x: FloatArray) -> FloatArray:
    """Lower x (k + 1,) to the largest values that can be reached from rest: u <= (r - b x) / a where a > 0."""
    a, b, r, width = cells
    binding = a > 0.0
    factor = np.where(binding, 1.0 - 2.0 * width * b / a, 0.0)
    offset = np.where(binding, 2.0 * width * r / a, np.inf)
    reached = x.copy()
    reached[0] = 0.0
    for k in range(len(a)):
        reached[k + 1] = min(x[k + 1], (factor[k] * reached[k] + offset[k]).min())
    return reached
