"""What is certain of a box: that it holds no pose within the limits with kappa <= K and the start's sign of det H."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.chart import Chart, Links, frame, links
from pipeline.bound.clearance import too_close
from pipeline.bound.forms import Form, constant, cross, inverse_root, joined
from pipeline.bound.kappa import exclude_by_kappa
from pipeline.machine.geometry import PRIMARY, TELESCOPES, TRIANGLE

_S = (4, 5)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What was found of n boxes, and for the search what halving them promises.

    Attributes
    ----------
    excluded : (n,)
        Every pose of the box has kappa > K, the other sign of det H, or breaks a limit.
    middle : (n,)
        kappa at the centre in floats.
    weights : (6, n)
        How much halving each coordinate promises.
    """

    excluded: BoolArray
    middle: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Evaluator:
    """Evaluates boxes of a chart for the start's sign of det H and kappa up to a target, K."""

    chart: Chart
    sign: float
    target: float

    def __call__(self, low: FloatArray, high: FloatArray) -> Evaluation:
        """Evaluate boxes (6, n)."""
        n = low.shape[1]
        excluded, middle, weights = np.ones(n, dtype=bool), np.full(n, np.inf), high - low
        at = frame(self.chart, low, high)
        low, high = _within_reach(low, high, at.D)
        keep = np.flatnonzero((low <= high).all(axis=0))
        if not keep.size:
            return Evaluation(excluded, middle, weights)
        low, high = low[:, keep], high[:, keep]
        found = links(self.chart, at.boxes(keep), low, high)
        some = np.flatnonzero(self._within_limits(found))
        if not some.size:
            return Evaluation(excluded, middle, weights)
        keep, found = keep[some], found.boxes(some)
        kappa = exclude_by_kappa(self._statics(found), found.ties, self.sign, self.target)
        excluded[keep], middle[keep] = kappa.excluded, kappa.middle
        widths = high[:, some] - low[:, some]
        spread = self.target * 0.125 * widths**2
        spread[self.chart.free] += kappa.spread
        weights[:, keep] = np.where(widths > 0.0, spread, 0.0)
        return Evaluation(excluded, middle, weights)

    def _within_limits(self, found: Links) -> BoolArray:
        machine = self.chart.machine
        inside: BoolArray = np.asarray(((found.ties.lower <= 0.0) & (found.ties.upper >= 0.0)).all(axis=0))
        travel = machine.travel_m
        for k, (i, j) in enumerate(((0, 2), (1, 2), (0, 1))):
            form = found.apart[k]
            inside &= (form.upper >= travel[i, 0] - travel[j, 1]) & (form.lower <= travel[i, 1] - travel[j, 0])
        for k, (shortest, longest) in enumerate(machine.strokes_m.tolist()):
            square = found.squares[k]
            inside &= (square.upper >= shortest**2 * (1.0 - 1e-12)) & (square.lower <= longest**2 * (1.0 + 1e-12))
        some = np.flatnonzero(inside) if machine.link_link_m > 0.0 else np.zeros(0, dtype=int)
        if some.size:
            inside[some[too_close(machine, found.arms.boxes(some), found.v.boxes(some))]] = False
        return inside

    def _statics(self, found: Links) -> Form:
        """Compute H as columns [u_l ; A'_l x u_l / L], (6 links, 6 rows, n)."""
        inverse = self._inverse_lengths(found.squares)
        u = found.v * inverse.expanded
        moment = cross(found.arms, u).times(1.0 / self.chart.machine.characteristic_length_m)
        return joined([*(u[:, i] for i in range(3)), *(moment[:, i] for i in range(3))], axis=1)

    def _inverse_lengths(self, squares: Form) -> Form:
        machine, n = self.chart.machine, squares.c.shape[-1]
        side = self.chart.joints_m[TRIANGLE] - self.chart.joints_m[PRIMARY[2]]
        lengths = machine.lengths_m.copy()
        lengths[TRIANGLE] = np.hypot(lengths[PRIMARY[2]], np.linalg.norm(side))
        parts = [constant(np.full(n, 1.0 / length), len(squares.g), 1e-15 / length) for length in lengths.tolist()]
        for k, link in enumerate(TELESCOPES.tolist()):
            shortest, longest = machine.strokes_m[k].tolist()
            parts[link] = inverse_root(squares[k], shortest**2, longest**2)
        return joined(parts)


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
