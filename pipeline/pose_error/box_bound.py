"""How far the tool may be from its pose over one proven box, for all errors of actuators and geometry.

With the symbols of a box (`pipeline.inclusion.krawczyk`) the pose is within k of x(t) + C(t) e + P(t) a, and without
errors within k0 of x(t). So the tool is off by

    |dp| <= max |C_xyz(t) e + P_xyz(t) a| + |k_xyz| + |k0_xyz|,

a norm of what is linear in t and in all errors: it is largest at an end of the interval, and at a corner of the errors.
The platform is turned by at most the length of the straight way between both orientations, in Euler angles. Its
angular velocity there, in axes turned by Rx, is [e_x, Rz e_y, e_z] times the rates w of rx, ry, rz, so that

    |omega|^2 = w_x^2 + w_y^2 + w_z^2 - 2 w_x w_y sin rz,

linear in sin rz: it is largest at an end of the range of sin rz. Each unit of k and k0 adds at most a unit.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from flint import arb

from pipeline.arrays import FloatArray
from pipeline.inclusion.condition import above, below
from pipeline.inclusion.growth import LEAST_RADIUS
from pipeline.inclusion.krawczyk import Box, Inclusion, include
from pipeline.inclusion.matrices import ball_matrix, magnitudes, times
from pipeline.inclusion.proven_box import ProvenBox

_ROUNDING = 1e-14
"""Relative to the sum of all magnitudes: sums and products of twelve terms in double precision are off by less."""
_SLACK, _SLACK_OF_REST, _LEAST_SLACK = 1e-4, 0.03, 1e-10
"""What the linear part of a bound and the rest are enlarged by, relatively, and metres or radians that are added."""
_RZ = 5


@dataclass(frozen=True)
class BoxError:
    """Bounds over a box.

    Attributes
    ----------
    position_m, rotation_rad : float
        How far the tool may be off, and by which angle turned.
    rest : float
        Part of the position that is not linear in the errors: what narrower boxes may reduce.
    """

    position_m: float
    rotation_rad: float
    rest: float


def bound_error(box: ProvenBox) -> BoxError | None:
    """Bound the tool's error over a box; None if the pose without errors is not proven to be in it."""
    inclusion = box.inclusion
    nominal = _without_errors(box)
    if nominal is None:
        return None
    ends, sizes = _symbols(box)
    corners = _corners(sizes)
    moved = np.stack([corners @ matrix.T for matrix in ends])
    most = np.abs(ends).max(axis=0) @ sizes
    position = np.sqrt((moved[..., :3] ** 2).sum(axis=-1)).max() + _ROUNDING * most[:3].sum()
    k = [a + b for a, b in zip(inclusion.image, nominal.image, strict=True)]
    rest = above((k[0] ** 2 + k[1] ** 2 + k[2] ** 2).sqrt())
    turned = max(_rate(moved[..., 3:], sine) for sine in _sines(box))
    return BoxError(
        position_m=_stated(position, rest),
        rotation_rad=_stated(turned + _ROUNDING * most[3:].sum(), above(sum(k[3:], arb(0)))),
        rest=rest,
    )


def _without_errors(box: ProvenBox) -> Inclusion | None:
    """Prove the pose without errors; None if it is not proven to be the one that the box holds."""
    whole = box.inclusion.box
    thin = Box(whole.first, whole.last, whole.pose, np.full(6, LEAST_RADIUS))
    nominal = include(box.balls, box.series, thin)
    if nominal is None:
        return None
    inside = all(k < r for k, r in zip(nominal.image, whole.radius.tolist(), strict=True))
    return nominal if inside else None


def _symbols(box: ProvenBox) -> tuple[FloatArray, FloatArray]:
    """Give [C, P] at both ends of the interval, (2, 6, m), and the sizes (m,) of the errors that are not zero."""
    inclusion, h = box.inclusion, above(box.series.half)
    matrix = np.concatenate([inclusion.inverse, inclusion.following.matrix], axis=2)
    sizes = np.array([above(e) if e > 0 else 0.0 for e in (*inclusion.residual_change, *inclusion.following.errors)])
    known = sizes > 0.0
    return np.stack([matrix[0] - matrix[1] * h, matrix[0] + matrix[1] * h])[..., known], sizes[known]


def _corners(sizes: FloatArray) -> FloatArray:
    """List the corners (n, m) of the errors but for their opposites, which are off as far."""
    signs = list(product((-1.0, 1.0), repeat=max(len(sizes) - 1, 0)))
    return np.array([(1.0, *rest)[: len(sizes)] for rest in signs]) * sizes


def _rate(w: FloatArray, sine: float) -> float:
    """Compute the largest |omega| for changes (..., 3) of rx, ry, rz."""
    squares = (w**2).sum(axis=-1)
    return float(np.sqrt((squares - 2.0 * w[..., 0] * w[..., 1] * sine + 4.0 * _ROUNDING * squares).max()))


def _sines(box: ProvenBox) -> tuple[float, float]:
    """Bound sin rz over all poses of a box from below and above."""
    inclusion = box.inclusion
    C = ball_matrix(inclusion.inverse[0]) + ball_matrix(inclusion.inverse[1]) * arb(0, box.series.half)
    by_geometry = times(magnitudes(C), inclusion.residual_change)[_RZ]
    reach = by_geometry + inclusion.following.moved[_RZ] + inclusion.image[_RZ]
    sine = (box.series.over.pose[_RZ][0] + arb(0, reach.upper())).sin()
    return below(sine), above(sine)


def _stated(linear: float, rest: float) -> float:
    """Add the parts of a bound, each a little larger, so that other arithmetic with wider enclosures verifies them."""
    return (1.0 + _SLACK) * linear + (1.0 + _SLACK_OF_REST) * rest + _LEAST_SLACK
