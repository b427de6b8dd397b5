"""The dependent angle ry off the axis, by Newton's method from the closed form, where its result is certain."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import wrap_angle
from pipeline.machine.triangle.closure import ARM3, coefficients, place_across, seen_along_rail, triangle_constants

_NEWTON_STEPS = 4
_SETTLED_RAD = 1e-6
"""Largest last step: Newton's method squares it, to less than rounding."""
_ROUNDING = 1e-12


def nearest_root(machine: Machine, controlled: FloatArray, signs: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Find the angles nearest to the closed form of the machine moved onto the axis, and where they are certain.

    With rho = |(a_x, a_z)| of a_3a and f the mismatch, Newton's method finds a root at a distance m from the closed
    form. Where 2 m max |f''| < |f'|, with a bound of f'' over all angles that near, f is monotonic there: there is no
    nearer root. It is certain, too, that there is no angle where link 3a does not reach whatever ry is, and where
    |C| exceeds hypot(A, B) by more than the offset may change. Two arrays (n,).
    """
    equation = _Equation.of(machine, controlled, signs)
    near, certain = equation.on_axis()
    angle = np.full(len(controlled), np.nan)
    rows = np.flatnonzero(np.isfinite(near) & ~certain)
    ry, at = near[rows], equation.at_rows(rows)
    for _ in range(_NEWTON_STEPS):
        ry, step, is_nearest = at.newton(ry, near[rows])
        settled = np.abs(step) < _SETTLED_RAD
        found = rows[settled & is_nearest]
        angle[found], certain[found] = ry[settled & is_nearest], True
        left = np.flatnonzero(~settled)
        if left.size == 0:
            break
        if left.size < rows.size / 2:
            rows, ry, at = rows[left], ry[left], at.at_rows(left)
    beyond = np.flatnonzero((angle <= -np.pi) | (angle > np.pi))
    angle[beyond] = wrap_angle(angle[beyond])
    return angle, certain


@dataclass(frozen=True, eq=False)
class _Equation:
    """The triangle closure f(ry) = k . g - d . R w - constant of many poses, with k = R w - d and Q = Rx Rz.

    Attributes
    ----------
    machine : Machine
        With a_3a anywhere.
    Q : (3, 3, n)
        Rotation by rx and rz, seen along rail 3.
    across : (2, n)
        How far the joint of link 3a would be from its cart across the rail if it were on the axis.
    signs : (n,)
        Working mode of arm 3.
    """

    machine: Machine
    Q: FloatArray
    across: FloatArray
    signs: FloatArray

    @classmethod
    def of(cls, machine: Machine, controlled: FloatArray, signs: FloatArray) -> "_Equation":
        cx, sx, cz, sz = (turn(controlled[:, k]) for k in (3, 4) for turn in (np.cos, np.sin))
        Q = np.zeros((3, 3, len(controlled)))
        Q[0, 0], Q[0, 1] = cz, -sz
        Q[1] = cx * sz, cx * cz, -sx
        Q[2] = sx * sz, sx * cz, cx
        if not machine.has_parallel_rails:
            Q = np.moveaxis(seen_along_rail(machine, np.moveaxis(Q, -1, 0)), 0, -1)
        place = place_across(machine, controlled)
        return cls(machine, Q, place.T + machine.platform_points_m[ARM3, 1] * Q[1:, 1], signs)

    def at_rows(self, rows: IntArray) -> "_Equation":
        """Pick rows."""
        return _Equation(self.machine, self.Q[..., rows], self.across[:, rows], self.signs[rows])

    def on_axis(self) -> tuple[FloatArray, BoolArray]:
        """Solve with a_3a on the axis, NaN where there is no solution; tell where there is none off it, either. (n,).

        The offset changes f by at most |dg| (|w| + |d|), where dg is at most rho across the rail.
        """
        w, d, _ = triangle_constants(self.machine)
        L, rho, modes = self.machine.lengths_m[ARM3], self._offset, np.abs(self.signs)
        squared = self.across[0] ** 2 + self.across[1] ** 2
        D = L**2 - squared
        along = np.sqrt(np.maximum(D, 0.0))
        A, B, C = coefficients(self.machine, self.Q, np.stack([-self.signs * along, *self.across]))
        amplitude = np.hypot(A, B)
        with np.errstate(invalid="ignore", divide="ignore"):
            near = np.arctan2(B, A) - self.machine.triangle_sign * np.arccos(C / amplitude)
        by = rho * (2.0 * np.sqrt(squared) + rho)
        change = np.hypot(rho, modes * np.sqrt(np.minimum(by, by**2 / np.maximum(D, 1e-300))))
        size = float(np.linalg.norm(w) + np.linalg.norm(d))
        folded = np.abs(C) > amplitude + change * size * (1.0 + _ROUNDING) + _ROUNDING
        short = (modes > 0.0) & (squared > ((L + rho) * (1.0 + _ROUNDING)) ** 2)
        return np.where((D < 0.0) & (modes > 0.0), np.nan, near), folded | short

    def newton(self, ry: FloatArray, near: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Do a step: angles after it, the step, and whether a root there is the nearest on the branch. Three (n,)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            value, slope, D, branch = self._values(ry)
            step = -value / slope
            moved = 2.0 * (np.abs(ry - near) + np.abs(step))
            is_nearest = np.abs(slope) > moved * self._largest_curvature(D, moved)
        return ry + step, step, is_nearest & (branch * self.machine.triangle_sign > 0.0)

    @property
    def _offset(self) -> float:
        x, _, z = self.machine.platform_points_m[ARM3]
        return float(np.hypot(x, z))

    def _values(self, ry: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Compute f, f', the discriminant D of arm 3 and which branch it is. Four arrays (n,)."""
        Q = self.Q
        w, d, constant = triangle_constants(self.machine)
        x, _, z = self.machine.platform_points_m[ARM3]
        c, s = np.cos(ry), np.sin(ry)
        e0, e2, f0, f2 = c * x + s * z, c * z - s * x, c * w[0] + s * w[2], c * w[2] - s * w[0]
        y, v = self.across + e0 * Q[1:, 0] + e2 * Q[1:, 2]
        dy, dv = e2 * Q[1:, 0] - e0 * Q[1:, 2]
        D = self.machine.lengths_m[ARM3] ** 2 - y * y - v * v
        along = self.signs / np.sqrt(np.where(self.signs == 0.0, 1.0, D))
        g, dg = (-along * D, y, v), (along * (y * dy + v * dv), dy, dv)
        side = [Q[i, 0] * f0 + Q[i, 1] * w[1] + Q[i, 2] * f2 for i in range(3)]
        branch = sum((g[i] - d[i]) * (Q[i, 0] * f2 - Q[i, 2] * f0) for i in range(3))
        slope = branch + sum(dg[i] * (side[i] - d[i]) for i in range(3))
        value = sum(g[i] * (side[i] - d[i]) - d[i] * side[i] for i in range(3)) - constant
        return value, slope, D, branch

    def _largest_curvature(self, D: FloatArray, moved: FloatArray) -> FloatArray:
        """Bound |f''| within an angle of where arm 3 has the discriminant D; infinite where it may run out. (n,)."""
        w, d, _ = triangle_constants(self.machine)
        L, rho, turning = self.machine.lengths_m[ARM3], self._offset, float(np.hypot(w[0], w[2]))
        size, fixed = np.linalg.norm(w) + np.linalg.norm(d), self.signs == 0.0
        least = np.where(fixed, 1.0, D - 2.0 * L * rho * moved)
        inverse = np.where(fixed, 0.0, 1.0 / np.sqrt(np.where(least > 0.0, least, np.nan)))
        first, slowing = rho + L * rho * inverse, L * rho * inverse
        second = rho + (rho**2 + L * rho) * inverse + slowing**2 * inverse
        bound = 2.0 * first * turning + second * size + (L + np.linalg.norm(d)) * turning
        return np.asarray(np.nan_to_num(bound, nan=np.inf))
