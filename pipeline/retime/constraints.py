"""Limits as linear inequalities in path acceleration and squared path speed, at every point of a grid."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.retime.path_dynamics import PathDynamics
from pipeline.retime.quantities import QUANTITIES, Quantities, Quantity, both_sides

_TCP_SIDES = 32
"""Sides of half the polygon that replaces the circle of TCP accelerations: its corners are 0.12 % farther out."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows a sdd + b sd^2 + c <= 1, each a fraction of a limit, and caps on sd.

    Attributes
    ----------
    a, b, c : (n, m)
        Coefficients at n points.
    cap : (n,)
        Largest sd within all limits on speeds.
    labels : tuple of (str, str)
        Name of the quantity and its subject, for each row.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    cap: FloatArray
    labels: tuple[tuple[str, str], ...]


def limit_rows(path: PathDynamics, outer: bool = False, quantities: Quantities = QUANTITIES) -> Rows:
    """Write the limits on quantities of second order as rows; quantities without a limit have none.

    The TCP's acceleration lies in the plane of its first two derivatives. A polygon replaces the circle there, with one
    side at either end of the tangent: inscribed, so that the rows keep the limit and give away up to 0.12 %.

    Parameters
    ----------
    outer : bool
        Circumscribe the polygon, so that everything within the limits satisfies the rows: bounds need that.
    """
    parts = [
        _two_sided(quantity, quantity.linear(path), quantity.limit(path.machine))
        for quantity in quantities
        if quantity.linear is not None and quantity.known(path.machine)
    ]
    if np.isfinite(path.machine.tcp_acceleration_mps2):
        parts.append(_tcp(path, path.machine.tcp_acceleration_mps2, outer))
    a, b, c = (np.concatenate([part[0][k] for part in parts], axis=1) for k in range(3))
    cap = speed_caps(path, quantities).min(axis=1)
    return Rows(a, b, c, cap, tuple(label for part in parts for label in part[1]))


def path_speeds(path: PathDynamics, quantities: Quantities = QUANTITIES) -> tuple[FloatArray, FloatArray]:
    """Compute every limited speed at sd = 1, (n, m), and the limits, (m,)."""
    chosen = [q for q in quantities if q.speed is not None and q.known(path.machine)]
    speeds = [quantity.speed(path) for quantity in chosen if quantity.speed is not None]
    return np.concatenate(speeds, axis=1), np.concatenate([quantity.limit(path.machine) for quantity in chosen])


def speed_caps(path: PathDynamics, quantities: Quantities = QUANTITIES) -> FloatArray:
    """Find the largest sd within each limit on a speed, infinite for subjects that stand still. Shape (n, m)."""
    speeds, allowed = path_speeds(path, quantities)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(speeds > 0.0, allowed / speeds, np.inf)


def largest_speed(rows: Rows) -> FloatArray:
    """Compute the maximum-velocity curve: the largest sd at which some path acceleration keeps all rows. Shape (n,).

    Two rows i, j with a_i > 0 > a_j leave room for sdd as long as (1 - c_i - b_i x) / a_i >= (1 - c_j - b_j x) / a_j.
    This bounds x = sd^2; so does every row with a_i = 0 by itself.
    """
    a, b, room = rows.a, rows.b, 1.0 - rows.c
    with np.errstate(divide="ignore", invalid="ignore"):
        largest = np.where((a == 0.0) & (b > 0.0), room / b, np.inf).min(axis=1)
        for i in range(a.shape[1]):
            up, down = a[:, i : i + 1], -a
            slope = b[:, i : i + 1] * down + b * up
            allowed = (room[:, i : i + 1] * down + room * up) / slope
            pairs = (up > 0.0) & (down > 0.0) & (slope > 0.0)
            largest = np.minimum(largest, np.where(pairs, allowed, np.inf).min(axis=1))
    return np.asarray(np.minimum(np.sqrt(np.maximum(largest, 0.0)), rows.cap))


_Coefficients = tuple[FloatArray, ...]
_Part = tuple[_Coefficients, list[tuple[str, str]]]


def _two_sided(quantity: Quantity, coefficients: _Coefficients, limit: FloatArray) -> _Part:
    """Write |a sdd + b sd^2 + c| <= limit as two rows, one for each sign, for each subject that has a limit."""
    limit = both_sides(limit)
    columns = np.flatnonzero(np.isfinite(limit).any(axis=0))
    positive, negative = limit[:, columns]
    both = tuple(
        np.concatenate([part[:, columns] / positive, -part[:, columns] / negative], axis=1) for part in coefficients
    )
    return both, [(quantity.name, quantity.subjects[k]) for k in columns.tolist()] * 2


def _tcp(path: PathDynamics, limit: float, outer: bool) -> _Part:
    """Write |tcp1 sdd + tcp2 sd^2| <= limit as the sides of a polygon for the half circle on the side of tcp2."""
    length = np.linalg.norm(path.tcp1, axis=1, keepdims=True)
    tangent = path.tcp1 / np.maximum(length, 1e-300)
    along = np.einsum("ni,ni->n", path.tcp2, tangent)[:, None]
    across = np.linalg.norm(path.tcp2 - along * tangent, axis=1, keepdims=True)
    angles = np.linspace(0.0, np.pi, _TCP_SIDES + 1)
    scale = limit if outer else limit * np.cos(np.pi / (2.0 * _TCP_SIDES))
    a = length * np.cos(angles) / scale
    b = (along * np.cos(angles) + across * np.sin(angles)) / scale
    return (a, b, np.zeros_like(a)), [("tcp_acceleration", "TCP")] * len(angles)
