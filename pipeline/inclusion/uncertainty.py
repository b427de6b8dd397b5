"""Errors of the machine: of lengths, of coordinates, of actuators, of a calibration; and what they do to the closures.

Constant errors a of a platform point, b of a cart's joint, g of a rail and d of a length change f_l by
v . w + |w|^2 / 2 - len d - d^2 / 2 with w = R a - b - g. Along the rail g is zero: b covers that error.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from flint import arb, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.calibrated import closures
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.closure import Closure, Geometry
from pipeline.machine.geometry import ACTUATORS


@dataclass(frozen=True)
class Uncertainty:
    """How far the machine may be from its configuration.

    Attributes
    ----------
    length_m : float
        Every link's length, telescopes included.
    coordinate_m : float
        Every coordinate of every platform point and cart offset, and y and z of every rail.
    actuator_m : tuple of 5
        Every actuator's distance from where it is commanded; it may vary with time.
    ellipsoid : Ellipsoid or None
        The machines that a calibration leaves possible, in place of all other errors.

    Raises
    ------
    ValueError
        If one of them is negative or not finite, or there are other errors beside an ellipsoid.
    """

    length_m: float = 0.0
    coordinate_m: float = 0.0
    actuator_m: tuple[float, ...] = (0.0,) * len(ACTUATORS)
    ellipsoid: Ellipsoid | None = None

    def __post_init__(self) -> None:
        if len(self.actuator_m) != len(ACTUATORS):
            raise ValueError(f"an uncertainty has the errors of {len(ACTUATORS)} actuators, not {len(self.actuator_m)}")
        for eps in (self.length_m, self.coordinate_m, *self.actuator_m):
            if not 0.0 <= eps < inf:
                raise ValueError(f"an uncertainty has to be finite and not negative, not {eps} m")
        if self.ellipsoid is not None and any((self.length_m, self.coordinate_m, *self.actuator_m)):
            raise ValueError("an uncertainty is of an ellipsoid, or of other errors, not of both")

    @property
    def any(self) -> bool:
        """Whether anything is uncertain."""
        return self.calibration or any(self.actuator_m)

    @property
    def largest_m(self) -> float:
        """The largest error of all."""
        return max(self.length_m, self.coordinate_m, *self.actuator_m)

    @property
    def calibration(self) -> bool:
        """Whether lengths or coordinates are uncertain."""
        return self.length_m > 0.0 or self.coordinate_m > 0.0 or self.ellipsoid is not None


CERTAIN = Uncertainty()
"""The machine is exactly as configured."""


def of_lengths(eps_m: float) -> Uncertainty:
    """Return an error of up to `eps_m` of every link length."""
    return Uncertainty(length_m=eps_m)


def of_everything(eps_m: float) -> Uncertainty:
    """Return an error of up to `eps_m` of every length and every coordinate."""
    return Uncertainty(length_m=eps_m, coordinate_m=eps_m)


def of_actuators(weights: FloatArray) -> Callable[[float], Uncertainty]:
    """Return a function that gives actuators an error of up to eps times their weight, (5,)."""
    return lambda eps_m: Uncertainty(actuator_m=tuple((eps_m * weights).tolist()))


def residual_change(machine: Geometry, over: Closure[arb_series], uncertainty: Uncertainty) -> list[arb]:
    """Bound E, the change of the closures at the poses x(t) by calibration. Six bounds in square metres.

    v and len are those of actuators that are off by up to `actuator_m`. Directions of rails are as configured.
    """
    if not uncertainty.calibration:
        return [arb(0)] * 6
    if uncertainty.ellipsoid is not None:
        return closures.residual_change(over, uncertainty.ellipsoid)
    eps, eta = arb(uncertainty.length_m), arb(uncertainty.coordinate_m)
    columns = [[row[j][0] for row in over.rotation] for j in range(3)]
    bounds, off = [], arb(max(uncertainty.actuator_m))
    for vector, length, rail in zip(over.vectors, over.lengths, over.rails, strict=True):
        v = [entry[0] + arb(0, (off * along).abs_upper()) for entry, along in zip(vector, rail, strict=True)]
        bound = (length[0].abs_upper() + off) * eps + eps * eps / 2
        if uncertainty.coordinate_m > 0.0:
            seen = sum(((c[0] * v[0] + c[1] * v[1] + c[2] * v[2]).abs_upper() for c in columns), arb(0))
            x, y, z = (entry.abs_upper() for entry in v)
            bound += eta * (seen + x + 2 * (y + z)) + _offset(eta) ** 2 / 2
        bounds.append(bound)
    return bounds


def jacobian_change(machine: Geometry, hull: Closure[arb], uncertainty: Uncertainty) -> list[list[arb]]:
    """Bound D, the change of f_l' over all poses of a box. 6 x 6 bounds.

    The derivative by the TCP changes by w, that by an angle by (axis x A') . w + (v + w) . (axis x R a).
    """
    eta = arb(uncertainty.coordinate_m)
    if uncertainty.coordinate_m == 0.0:
        return [[arb(0)] * 6] * 6
    w, turned, off = _offset(eta), arb(3).sqrt() * eta, arb(max(uncertainty.actuator_m))
    rows = []
    for point, vector, rail in zip(machine.points, hull.vectors, hull.rails, strict=True):
        by_angle = _norm(point) * w + (_norm(vector) + off * _norm(rail) + w) * turned
        rows.append([(turned + 2 * eta)] * 3 + [by_angle] * 3)
    return rows


def _offset(eta: arb) -> arb:
    """Bound |w|: sqrt(3) eta from the platform; on the cart's side eta along the rail and 2 eta across, each way."""
    return (arb(3).sqrt() + 3) * eta


def _norm(vector: list[arb]) -> arb:
    return (vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2).sqrt().abs_upper()
