"""What a controller makes of the rows of a motion that it interpolates by itself, one row per period.

From row to row it may move by

    linear    positions                                    velocities jump at the rows
    cubic     positions and velocities (Hermite)           accelerations jump
    quintic   positions, velocities and accelerations      jerk jumps

All are polynomials between two rows, and so is the motion q(s(t)) between rows, pieces of the law and knots of the
path. Their differences are bounded by their Bernstein coefficients, derivatives by values at many instants and the
error of lines between these: no instant exceeds what is stated, but for the rounding of floats.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from math import comb, factorial

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arrays import FloatArray, IntArray
from pipeline.inclusion.pieces import distinct_knots
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.parallel import blocks
from pipeline.retime.quantities import JERK, quantity_named
from pipeline.retime.result import Trajectory, TrajectorySamples, stretched
from pipeline.retime.sampling import sample_trajectory, whole_periods
from pipeline.summary.trajectory import ROW_LIMIT

METHODS = {"linear": 1, "cubic": 3, "quintic": 5}
"""Interpolations, and the degrees of their polynomials."""
_NAMES = ("velocity", "acceleration", JERK)
_JUMPS = ("velocity_mps", "acceleration_mps2", "jerk_mps3")
_PARTS = 64
"""Parts of a period at whose ends derivatives are evaluated."""
_BEYOND = 1.0 + 1e-4
"""How much farther time is stretched than is needed."""
_BATCH = 4_000
"""Intervals evaluated at a time."""


@dataclass(frozen=True, eq=False)
class Interpolation:
    """A motion as one interpolation makes it of its rows, bounds for every actuator (5,).

    Attributes
    ----------
    method : str
        One of `METHODS`.
    period_s : float
        Time between two rows.
    deviation_m : (5,)
        Distance from the motion itself.
    usage : mapping
        Parts of the limits that are used between rows, by name; of what the polynomials have.
    jump : (str, (5,))
        What jumps at the rows, with its unit, and how far.
    """

    method: str
    period_s: float
    deviation_m: FloatArray
    usage: dict[str, FloatArray]
    jump: tuple[str, FloatArray]

    @property
    def largest(self) -> float:
        """The largest part of a limit."""
        return float(max(part.max() for part in self.usage.values()))

    @property
    def stretch(self) -> float:
        """Factor by which time has to be stretched for all limits to be kept, if that changes the motion alone."""
        powers = {name: order for order, name in enumerate(_NAMES, start=1)}
        return float(max([1.0, *(part.max() ** (1.0 / powers[name]) for name, part in self.usage.items())]))

    @property
    def warning(self) -> str:
        """Say which limit is exceeded; empty if none is, by more than a thousandth."""
        if self.largest <= ROW_LIMIT:
            return ""
        name = max(self.usage, key=lambda name: self.usage[name].max())
        actuator = ACTUATORS[int(self.usage[name].argmax())]
        return (
            f"rows {self.period_s:g} s apart, interpolated by {self.method} polynomials, take {actuator} to "
            f"{self.largest:.2%} of its {name} limit"
        )


def interpolations(trajectory: Trajectory, samples: TrajectorySamples, *, jerk: bool = True) -> list[Interpolation]:
    """Bound what each interpolation makes of the rows of a trajectory that takes whole periods.

    Without `jerk` it is not limited, and accelerations of the motion may jump.
    """
    limits = _limits(trajectory.path.machine, jerk=jerk and not trajectory.jerk_jumps)
    rows, motion = _Rows(samples), _Motion(trajectory, samples.t_s)
    found = []
    for method, degree in METHODS.items():
        order = (degree + 1) // 2
        usage = {
            name: np.where(np.isfinite(limits[k]), rows.peaks(degree, k + 1) / limits[k], 0.0)
            for k, name in enumerate(_NAMES)
            if np.isfinite(limits[k]).any() and k + 1 <= max(order, 1) + (degree > 1)
        }
        jump = (_JUMPS[order - 1], rows.jump(degree, order))
        found.append(Interpolation(method, samples.period_s, motion.deviation(rows, degree), usage, jump))
    return found


def safe_to_interpolate(
    trajectory: Trajectory, period_s: float, *, jerk: bool = True, methods: Collection[str] = tuple(METHODS)
) -> Trajectory:
    """Stretch time until rows a period apart keep all limits, whichever of some interpolations they are read by.

    Limits of what the polynomials have: velocities that jump between lines, or accelerations that jump between cubics,
    still do. The slower a motion is, the nearer polynomials between its rows are to it, and the less of the limits
    both use.

    Raises
    ------
    UnfitConfigError
        When that makes more rows than a table may have.
    """
    trajectory = whole_periods(trajectory, period_s)
    while True:
        of_all = interpolations(trajectory, sample_trajectory(trajectory, period_s), jerk=jerk)
        found = [one for one in of_all if one.method in methods]
        if max(one.largest for one in found) <= 1.0:
            return trajectory
        factor = _BEYOND * max(one.stretch for one in found)
        longer = sum(trajectory.dwell_s) + trajectory.motion_s * factor
        trajectory = whole_periods(stretched(trajectory, longer), period_s)


def _limits(machine: Machine, *, jerk: bool) -> FloatArray:
    """Give the limits of velocity, acceleration and jerk, (3, 5); infinite where there is none."""
    rows = np.stack([quantity_named(name).limit(machine) for name in _NAMES])
    rows[2] = rows[2] if jerk else np.inf
    return rows


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of a motion, and the polynomials between them."""

    samples: TrajectorySamples

    @cached_property
    def _scaled(self) -> FloatArray:
        """Positions, velocities and accelerations by periods, (3, rows, 5)."""
        h, rows = self.samples.period_s, self.samples
        return np.stack([rows.q_m, rows.qd_mps * h, rows.qdd_mps2 * h * h])

    def between(self, degree: int, rows: IntArray | slice = slice(None)) -> FloatArray:
        """Give the coefficients of x^n from one row (x = 0) to the next (x = 1), (degree + 1, n, 5)."""
        count = (degree + 1) // 2
        known = np.concatenate([self._scaled[:count, :-1][:, rows], self._scaled[:count, 1:][:, rows]])
        return np.asarray(np.einsum("ij,jnk->ink", np.linalg.inv(_conditions(degree)), known))

    def peaks(self, degree: int, order: int) -> FloatArray:
        """Bound a derivative of all polynomials (5,), in SI units."""
        largest, at = (
            np.zeros(len(ACTUATORS)),
            np.vander(np.linspace(0.0, 1.0, _PARTS + 1), degree + 1, increasing=True),
        )
        for part in blocks(len(self.samples) - 1, _BATCH):
            f = _derivative(self.between(degree, part), order)
            values = np.abs(np.einsum("pi,ink->pnk", at[:, : len(f)], f)).max(axis=(0, 1))
            bend = np.abs(_derivative(f, 2)).sum(axis=0).max(axis=0, initial=0.0) / 8.0 / _PARTS**2
            largest = np.maximum(largest, values + bend)
        return np.asarray(largest / self.samples.period_s**order)

    def jump(self, degree: int, order: int) -> FloatArray:
        """Compute the largest jump of a derivative at the rows, rest before and after them included, (5,)."""
        f = _derivative(self.between(degree), order)
        rest = np.zeros((1, f.shape[2]))
        begins, ends = np.concatenate([f[0], rest]), np.concatenate([rest, f.sum(axis=0)])
        return np.asarray(np.abs(begins - ends).max(axis=0) / self.samples.period_s**order)


def _conditions(degree: int) -> FloatArray:
    """Give values and derivatives at x = 0 and at x = 1 by coefficients, (degree + 1, degree + 1)."""
    rows = []
    for x in (0.0, 1.0):
        for order in range((degree + 1) // 2):
            unit = _derivative(np.eye(degree + 1)[:, :, None], order)[:, :, 0]
            rows.append(np.polynomial.polynomial.polyval(x, unit))
    return np.array(rows)


def _derivative(coefficients: FloatArray, order: int) -> FloatArray:
    """Differentiate polynomials, coefficients first; at least one remains."""
    for _ in range(order):
        if len(coefficients) == 1:
            return np.zeros_like(coefficients)
        coefficients = coefficients[1:] * np.arange(1.0, len(coefficients)).reshape(-1, *[1] * (coefficients.ndim - 1))
    return coefficients


class _Motion:
    """The motion itself between rows, pieces of the law and knots of the path: polynomials of u, -1 <= u <= 1.

    Before and after its law it is at rest, which a row need not begin or end with.
    """

    def __init__(self, trajectory: Trajectory, t_s: FloatArray) -> None:
        spline, law = trajectory.path.spline, trajectory.time_law
        knots, self._rows = distinct_knots(spline), t_s - trajectory.dwell_s[0]
        taylor = [spline(knots[:-1], nu=order) / factorial(order) for order in range(spline.k, -1, -1)]
        self._law, self._path = law, PPoly(np.stack(taylor), knots)
        passed = [law.solve(knot, discontinuity=False, extrapolate=False) for knot in knots[1:-1].tolist()]
        breaks = np.unique(np.concatenate([law.x, self._rows, *passed]))
        apart = np.diff(breaks) > 1e-9 * trajectory.motion_s / len(breaks)
        self._begins, self._ends = breaks[:-1][apart], breaks[1:][apart]

    def deviation(self, rows: _Rows, degree: int) -> FloatArray:
        """Bound how far the polynomials between rows are from the motion, (5,)."""
        largest, h = np.zeros(len(ACTUATORS)), rows.samples.period_s
        for part in blocks(len(self._begins), _BATCH):
            begins, ends = self._begins[part], self._ends[part]
            middle, half = (begins + ends) / 2.0, (ends - begins) / 2.0
            row = np.clip(np.searchsorted(self._rows, middle, side="right") - 1, 0, len(self._rows) - 2)
            x = np.stack([(middle - self._rows[row]) / h, half / h])
            guess, q = _substituted(rows.between(degree, row), x[:, :, None]), self._positions(middle, half)
            difference = q - np.pad(guess, ((0, len(q) - len(guess)), (0, 0), (0, 0)))
            largest = np.maximum(largest, _bernstein_magnitudes(difference).max(axis=0, initial=0.0))
        return largest

    def _positions(self, middle: FloatArray, half: FloatArray) -> FloatArray:
        """Compose positions with s over intervals, (powers, n, 5)."""
        piece = np.clip(np.searchsorted(self._law.x, middle, side="right") - 1, 0, self._law.c.shape[1] - 1)
        s = _substituted(self._law.c[::-1, piece], np.stack([middle - self._law.x[piece], half]))
        within = middle.clip(self._law.x[0], self._law.x[-1])
        rests = middle != within
        s[1:, rests], s[0, rests] = 0.0, self._law(within[rests])
        at = np.clip(np.searchsorted(self._path.x, s[0], side="right") - 1, 0, self._path.c.shape[1] - 1)
        s[0] -= self._path.x[at]
        return _composed(self._path.c[:, at], s[:, :, None])


def _substituted(coefficients: FloatArray, x: FloatArray) -> FloatArray:
    """Substitute x0 + x1 u into polynomials, coefficients first."""
    return _composed(coefficients[::-1], x)


def _composed(highest_first: FloatArray, inner: FloatArray) -> FloatArray:
    """Compose polynomials with others, both by arrays of coefficients; the outer ones begin with the highest power."""
    result = highest_first[:1]
    for row in highest_first[1:]:
        product = np.zeros((len(result) + len(inner) - 1, *result.shape[1:]))
        for n, factor in enumerate(inner):
            product[n : n + len(result)] += result * factor
        product[0] += row
        result = product
    return result


def _bernstein_magnitudes(coefficients: FloatArray) -> FloatArray:
    """Bound polynomials over |u| <= 1 by the largest of their Bernstein coefficients."""
    degree = len(coefficients) - 1
    # u = 2 v - 1, then sum of a_n v^n has the coefficients b_k = sum of C(k, n) / C(degree, n) a_n.
    shifted = np.array(
        [[comb(n, k) * 2.0**k * (-1.0) ** (n - k) for n in range(degree + 1)] for k in range(degree + 1)]
    )
    to_bernstein = np.array([[comb(k, n) / comb(degree, n) for n in range(degree + 1)] for k in range(degree + 1)])
    return np.asarray(np.abs(np.einsum("kn,n...->k...", to_bernstein @ shifted, coefficients)).max(axis=0))
