"""A time law of quartic pieces, on breakpoints fixed in s and given by the states there; its jerk is continuous.

Within a piece of h seconds the path jerk goes from j0 to j1 in a straight line. With r the elapsed part of h:

    s    = s0 + v0 (r h) + w0 (r h)^2 / 2 + j0 (r h)^3 / 6 + (j1 - j0) r (r h)^3 / 24
    sd   = v0 + w0 (r h) + j0 (r h)^2 / 2 + (j1 - j0) r (r h)^2 / 6
    sdd  = w0 + j0 (r h) + (j1 - j0) r (r h) / 2
    sddd = j0 + (j1 - j0) r
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class QuarticLaw:
    """A time law: path speed v, acceleration w and jerk j (n + 1,) at breakpoints s (n + 1,), h (n,) seconds apart."""

    s: FloatArray
    v: FloatArray
    w: FloatArray
    j: FloatArray
    h: FloatArray

    def state(self, piece: Any, part: Any) -> tuple[Any, Any, Any, Any]:
        """Evaluate s, sd, sdd, sddd when a part (0 to 1) of a piece has elapsed; both may be arrays of one shape."""
        ends = (self.s[piece], self.v[piece], self.w[piece], self.j[piece], self.j[piece + 1], self.h[piece])
        return quartic(*ends, part)

    def time_law(self) -> PPoly:
        """Convert to s(t), piecewise polynomial; pieces meet to within rounding."""
        rise = np.diff(self.j) / self.h
        t = np.concatenate([[0.0], np.cumsum(self.h)])
        return PPoly(np.stack([rise / 24.0, self.j[:-1] / 6.0, self.w[:-1] / 2.0, self.v[:-1], self.s[:-1]]), t)


def slowed(law: QuarticLaw, factor: float) -> QuarticLaw:
    """Take `factor` times as long: v, w, j are divided by its first, second and third power."""
    return QuarticLaw(law.s, law.v / factor, law.w / factor**2, law.j / factor**3, law.h * factor)


def quartic(s0: Any, v0: Any, w0: Any, j0: Any, j1: Any, h: Any, part: Any) -> tuple[Any, Any, Any, Any]:
    """Evaluate s, sd, sdd, sddd in a piece, for numbers or expressions."""
    t, rise = part * h, (j1 - j0) * part
    return (
        s0 + v0 * t + w0 * t**2 / 2.0 + j0 * t**3 / 6.0 + rise * t**3 / 24.0,
        v0 + w0 * t + j0 * t**2 / 2.0 + rise * t**2 / 6.0,
        w0 + j0 * t + rise * t / 2.0,
        j0 + rise,
    )


def halved(law: QuarticLaw, chosen: BoolArray) -> QuarticLaw:
    """Split the chosen pieces (n,) in the middle of their time; the time law stays the same."""
    which = np.flatnonzero(chosen)
    middle = law.state(which, 0.5)
    states = zip((law.s, law.v, law.w, law.j), middle, strict=True)
    s, v, w, j = (np.insert(part, which + 1, value) for part, value in states)
    h = np.where(chosen, law.h / 2.0, law.h)
    return QuarticLaw(s, v, w, j, np.insert(h, which + 1, h[which]))
