"""Limits as rows of linear inequalities in path acceleration and squared path speed, a set per place of a grid."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.retime.path_dynamics import Terms
from pipeline.retime.quantities import kind_named, limits

_TCP_SIDES = 32
"""Sides of half the polygon that stands for the circle of TCP accelerations: corners are 0.12 % farther than sides."""

_DRIVES_LINKS = (slice(0, 5), slice(5, 11))
"""Where the coefficients of drives and of links are among those of all forces."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows a sdd + b sd^2 + c <= 1, all fractions of a limit, and caps on sd.

    Attributes
    ----------
    a, b, c : (n, m)
        Coefficients at each of n places.
    cap : (n,)
        Largest sd that all limits of first order allow.
    labels : tuple of (str, str)
        Kind of limit and its subject, for each row.
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    cap: FloatArray
    labels: tuple[tuple[str, str], ...]


def limit_rows(terms: Terms, outer: bool = False) -> Rows:
    """Write all limits but those of jerk as rows; what is not limited has none.

    The TCP's acceleration lies in the plane of its first two derivatives. A polygon stands for the circle there, with
    a side towards either end of the tangent: inscribed, so that the rows keep the limit and give away up to 0.12 %.

    Parameters
    ----------
    outer : bool
        Circumscribe the polygon: then whatever keeps the limits keeps the rows, which bounds need.
    """
    limit = limits(terms.machine)
    parts = [_both((terms.q1, terms.q2, np.zeros_like(terms.q1)), limit["acceleration"], "acceleration")]
    if terms.machine.masses is not None:
        drives, links = (tuple(part[:, those] for part in (terms.a, terms.b, terms.c)) for those in _DRIVES_LINKS)
        parts.append(_both((*drives[:2], drives[2] + terms.friction()), limit["force"], "force"))
        parts.append(_both(links, limit["link_force"], "link_force"))
    if np.isfinite(limit["tcp_acceleration"]).any():
        parts.append(_tcp(terms, limit["tcp_acceleration"].item(), outer))
    a, b, c = (np.concatenate([part[0][k] for part in parts], axis=1) for k in range(3))
    return Rows(a, b, c, speed_caps(terms).min(axis=1), tuple(label for part in parts for label in part[1]))


def speed_caps(terms: Terms) -> FloatArray:
    """Largest sd within the velocity limit of each actuator and of the TCP, infinite for what stands. Shape (n, 6)."""
    limit = limits(terms.machine)
    speeds = np.concatenate([np.abs(terms.q1), np.linalg.norm(terms.tcp1, axis=1, keepdims=True)], axis=1)
    allowed = np.concatenate([limit["velocity"], limit["tcp_speed"]])
    with np.errstate(divide="ignore", invalid="ignore"):
        caps: FloatArray = np.where(speeds > 0.0, allowed / speeds, np.inf)
    return caps


def largest_speed(rows: Rows) -> FloatArray:
    """The maximum-velocity curve: the largest sd at which some path acceleration keeps all rows. Shape (n,).

    Two rows i, j with a_i > 0 > a_j leave room for sdd while (1 - c_i - b_i x) / a_i >= (1 - c_j - b_j x) / a_j, which
    bounds x = sd^2; so does every row with a_i = 0 by itself.
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
    speed: FloatArray = np.minimum(np.sqrt(np.maximum(largest, 0.0)), rows.cap)
    return speed


_Coefficients = tuple[FloatArray, ...]
_Part = tuple[_Coefficients, list[tuple[str, str]]]


def _both(coefficients: _Coefficients, limit: FloatArray, kind: str) -> _Part:
    """Write |a sdd + b sd^2 + c| <= limit as two rows for each subject that has a limit."""
    those = np.flatnonzero(np.isfinite(limit))
    scaled = [part[:, those] / limit[those] for part in coefficients]
    labels = [(kind, kind_named(kind).subjects[k]) for k in those.tolist()]
    return tuple(np.concatenate([part, -part], axis=1) for part in scaled), labels * 2


def _tcp(terms: Terms, limit: float, outer: bool) -> _Part:
    """Write |tcp1 sdd + tcp2 sd^2| <= limit as the sides of a polygon for the half circle on the side of tcp2."""
    length = np.linalg.norm(terms.tcp1, axis=1, keepdims=True)
    tangent = terms.tcp1 / np.maximum(length, 1e-300)
    along = np.einsum("ni,ni->n", terms.tcp2, tangent)[:, None]
    across = np.linalg.norm(terms.tcp2 - along * tangent, axis=1, keepdims=True)
    angles = np.linspace(0.0, np.pi, _TCP_SIDES + 1)
    scale = limit if outer else limit * np.cos(np.pi / (2.0 * _TCP_SIDES))
    a = length * np.cos(angles) / scale
    b = (along * np.cos(angles) + across * np.sin(angles)) / scale
    return (a, b, np.zeros_like(a)), [("tcp_acceleration", "TCP")] * len(angles)
