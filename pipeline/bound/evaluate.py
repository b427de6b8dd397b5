"""What is certain of a box: that it holds no pose within the limits, or from which kappa on it holds one."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.chart import Chart, frame, links
from pipeline.bound.clearance import too_close
from pipeline.bound.forms import Form, constant, inverse_root, joined, sum_of
from pipeline.bound.kappa import LARGEST, kappa_bounds, statics
from pipeline.machine.geometry import PRIMARY, TELESCOPES, TRIANGLE

_S = (4, 5)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Of n boxes: a lower bound of kappa within the limits, `LARGEST` if no pose of it is; for the search also more.

    Attributes
    ----------
    least : (n,)
        Every pose of the box has a larger kappa, the other sign of det H, or breaks a limit.
    middle : (n,)
        kappa at the centre in floats.
    weights : (6, n)
        How much halving each coordinate promises.
    """

    least: FloatArray
    middle: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Evaluator:
    """Evaluates boxes of a chart for the start's sign of det H; `target` is the kappa that matters."""

    chart: Chart
    sign: float
    target: float

    def __call__(self, low: FloatArray, high: FloatArray) -> Evaluation:
        """Evaluate boxes (6, n)."""
        n = low.shape[1]
        least, middle = np.full(n, LARGEST), np.full(n, np.inf)
        weights = high - low
        at = frame(self.chart, low, high)
        low, high = _within_reach(low, high, at.D)
        keep = np.flatnonzero((low <= high).all(axis=0))
        if not keep.size:
            return Evaluation(least, middle, weights)
        low, high = low[:, keep], high[:, keep]
        at = type(at)(*(getattr(at, part).boxes(keep) for part in ("P", "u3", "across", "D")))
        found = links(self.chart, at, low, high)
        inside = self._within_limits(found.v, found.carts, found.mismatch)
        some = np.flatnonzero(inside)
        if not some.size:
            return Evaluation(least, middle, weights)
        keep, v, mismatch = keep[some], found.v.boxes(some), found.mismatch.boxes(some)
        unit = self.chart.machine.characteristic_length_m
        joints = self.chart.joints_m / unit
        u, H = statics(v, self.chart.joints_m, self._inverse_lengths(v), unit)
        kappa = kappa_bounds(u, H, joints, mismatch, self.sign, self.target)
        least[keep], middle[keep] = kappa.least, kappa.middle
        widths = high[:, some] - low[:, some]
        spread = self.target * 0.125 * widths**2
        spread[self.chart.free] += kappa.spread
        weights[:, keep] = np.where(widths > 0.0, spread, 0.0)
        return Evaluation(least, middle, weights)

    def _within_limits(self, v: Form, carts: Form, mismatch: Form) -> BoolArray:
        machine = self.chart.machine
        inside: BoolArray = np.asarray(((mismatch.lower <= 0.0) & (mismatch.upper >= 0.0)).all(axis=0))
        travel = machine.travel_m
        apart = [(carts[0], 0, 2), (carts[1], 1, 2), (carts[0] - carts[1], 0, 1)]
        for form, i, j in apart:
            inside &= (form.upper >= travel[i, 0] - travel[j, 1]) & (form.lower <= travel[i, 1] - travel[j, 0])
        for link, (shortest, longest) in zip(TELESCOPES.tolist(), machine.strokes_m.tolist(), strict=True):
            square = _square(v[link])
            inside &= (square.upper >= shortest**2 * (1.0 - 1e-12)) & (square.lower <= longest**2 * (1.0 + 1e-12))
        if machine.link_link_m > 0.0:
            some = np.flatnonzero(inside)
            if some.size:
                inside[some[too_close(machine, self.chart.joints_m, v.boxes(some))]] = False
        return inside

    def _inverse_lengths(self, v: Form) -> Form:
        machine, n = self.chart.machine, v.c.shape[-1]
        lengths = machine.lengths_m.copy()
        lengths[TRIANGLE] = np.hypot(
            lengths[PRIMARY[2]], np.linalg.norm(self.chart.joints_m[TRIANGLE] - self.chart.joints_m[PRIMARY[2]])
        )
        telescopes = dict(zip(TELESCOPES.tolist(), machine.strokes_m.tolist(), strict=True))
        parts = []
        for link in range(len(lengths)):
            if link in telescopes:
                shortest, longest = telescopes[link]
                parts.append(inverse_root(_square(v[link]), shortest**2, longest**2))
            else:
                parts.append(constant(np.full(n, 1.0 / lengths[link]), len(v.g), 1e-15 / lengths[link]))
        return joined(parts)


def _square(v: Form) -> Form:
    return sum_of([v[i] * v[i] for i in range(3)])


def _within_reach(low: FloatArray, high: FloatArray, D: Form) -> tuple[FloatArray, FloatArray]:
    """Narrow s_1 and s_2 to what s_k^2 = D_k allows; where that is nothing, the bounds cross."""
    low, high = low.copy(), high.copy()
    for k, row in enumerate(_S):
        below, above = D.lower[k], D.upper[k]
        outer = np.sqrt(np.maximum(above, 0.0)) * (1.0 + 1e-15) + 1e-300
        inner = np.sqrt(np.maximum(below, 0.0)) * (1.0 - 1e-15)
        low[row], high[row] = np.maximum(low[row], -outer), np.minimum(high[row], outer)
        right, left = low[row] > -inner, high[row] < inner
        low[row] = np.where(right & (inner > 0.0), np.maximum(low[row], inner), low[row])
        high[row] = np.where(left & (inner > 0.0), np.minimum(high[row], -inner), high[row])
        high[row] = np.where(above < 0.0, low[row] - 1.0, high[row])
    return low, high
