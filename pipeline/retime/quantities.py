"""The quantities of a motion that a machine limits, a row each: name, unit, subjects, limit, and how it is computed.

Everything that measures, plans or draws motions loops over these rows. With sd, sdd, sddd for the derivatives of s(t):

    velocity      q' sd
    acceleration  q' sdd + q'' sd^2
    jerk          q' sddd + 3 q'' sd sdd + q''' sd^3
    force         a sdd + b sd^2 + c
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine
from pipeline.retime.path_dynamics import PathDynamics, needs_kinematics

JERK = "jerk"
_NO_ROOM = 1e-12
"""Fraction of a limit that counts as no room at all."""


class TimeDerivatives(NamedTuple):
    """Derivatives of s by time at n places, each a column (n, 1)."""

    sd: FloatArray
    sdd: FloatArray
    sddd: FloatArray


Value = Callable[[PathDynamics, TimeDerivatives], FloatArray]
LinearForm = Callable[[PathDynamics], tuple[FloatArray, FloatArray, FloatArray]]


def _always(machine: Machine) -> bool:
    return True


def _with_masses(machine: Machine) -> bool:
    return machine.masses is not None


@dataclass(frozen=True)
class Quantity:
    """A quantity of a motion that may be limited.

    Attributes
    ----------
    name, unit : str
        Its key in results, and its unit.
    subjects : tuple of str
        What has it, in the order of its columns: actuators, links, or the TCP.
    limit : function of a machine
        Largest magnitude of each subject, (subjects,); where they differ, of positive and of negative values,
        (2, subjects). Infinite where there is no limit.
    value : function of path dynamics and derivatives of s by time
        Values at n places, (n, subjects); magnitudes for the TCP, signed otherwise.
    power : int or None
        Stretching time by f divides it by f^power; None where part of it stays, such as gravity.
    known : function of a machine
        Whether it can be computed: forces need masses, quantities of the TCP need its kinematics.
    speed : function of path dynamics, or None
        For quantities of first order: magnitude per path speed sd, (n, subjects).
    linear : function of path dynamics, or None
        For quantities of second order: a, b, c (n, subjects) with value = a sdd + b sd^2 + c.
    """

    name: str
    unit: str
    subjects: tuple[str, ...]
    limit: Callable[[Machine], FloatArray]
    value: Value
    power: int | None = None
    known: Callable[[Machine], bool] = _always
    speed: Callable[[PathDynamics], FloatArray] | None = None
    linear: LinearForm | None = None

    @property
    def words(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ").replace("tcp", "TCP")

    @property
    def key(self) -> str:
        """The name with its unit as a suffix, as keys of results have it."""
        return f"{self.name}_{self.unit.replace('/', 'p').replace('^', '').lower()}"


def _velocity_limit(machine: Machine) -> FloatArray:
    """Velocity limits; those of locked actuators (zero) are checked before planning, and limit nothing here."""
    return np.where(machine.velocity_mps > 0.0, machine.velocity_mps, np.inf)


def _drive_force(path: PathDynamics, t: TimeDerivatives) -> FloatArray:
    """Forces of the drives; a machine at rest has no friction to overcome."""
    moving = (t.sd != 0.0) | (t.sdd != 0.0)
    return np.asarray(path.a[:, :5] * t.sdd + path.b[:, :5] * t.sd**2 + path.c[:, :5] + path.friction() * moving)


def _magnitude(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=1, keepdims=True))


QUANTITIES = (
    Quantity(
        "velocity",
        "m/s",
        ACTUATORS,
        power=1,
        limit=_velocity_limit,
        value=lambda path, t: path.q1 * t.sd,
        speed=lambda path: np.abs(path.q1),
    ),
    Quantity(
        "acceleration",
        "m/s^2",
        ACTUATORS,
        power=2,
        limit=lambda machine: machine.acceleration_mps2,
        value=lambda path, t: path.q1 * t.sdd + path.q2 * t.sd**2,
        linear=lambda path: (path.q1, path.q2, np.zeros_like(path.q1)),
    ),
    Quantity(
        JERK,
        "m/s^3",
        ACTUATORS,
        power=3,
        limit=lambda machine: machine.jerk_mps3,
        value=lambda path, t: path.q1 * t.sddd + 3.0 * path.q2 * t.sd * t.sdd + path.q3 * t.sd**3,
    ),
    Quantity(
        "force",
        "N",
        ACTUATORS,
        limit=lambda machine: machine.force_limits_n[:, :5],
        value=_drive_force,
        known=_with_masses,
        linear=lambda path: (path.a[:, :5], path.b[:, :5], path.c[:, :5] + path.friction()),
    ),
    Quantity(
        "link_force",
        "N",
        tuple(f"link {link}" for link in LINKS),
        limit=lambda machine: machine.force_limits_n[:, 5:],
        value=lambda path, t: path.a[:, 5:] * t.sdd + path.b[:, 5:] * t.sd**2 + path.c[:, 5:],
        known=_with_masses,
        linear=lambda path: (path.a[:, 5:], path.b[:, 5:], path.c[:, 5:]),
    ),
    Quantity(
        "tcp_speed",
        "m/s",
        ("TCP",),
        power=1,
        limit=lambda machine: np.array([machine.tcp_speed_mps]),
        value=lambda path, t: _magnitude(path.tcp1 * t.sd),
        known=needs_kinematics,
        speed=lambda path: _magnitude(path.tcp1),
    ),
    Quantity(
        "tcp_acceleration",
        "m/s^2",
        ("TCP",),
        power=2,
        limit=lambda machine: np.array([machine.tcp_acceleration_mps2]),
        value=lambda path, t: _magnitude(path.tcp1 * t.sdd + path.tcp2 * t.sd**2),
        known=needs_kinematics,
    ),
)
"""All quantities; the force of a link is along its axis."""

Quantities = tuple[Quantity, ...]


def quantity_named(name: str, quantities: Quantities = QUANTITIES) -> Quantity:
    """Find a quantity by its name."""
    return next(quantity for quantity in quantities if quantity.name == name)


def limits(machine: Machine, quantities: Quantities = QUANTITIES) -> dict[str, FloatArray]:
    """Limits, as `Quantity.limit` gives them, by the names of the quantities; infinite where there is none."""
    return {quantity.name: quantity.limit(machine) for quantity in quantities}


def both_sides(limit: FloatArray) -> FloatArray:
    """Return the limits of positive and of negative values, (2, subjects), of a limit as `Quantity.limit` gives it."""
    return np.broadcast_to(limit, (2, np.shape(limit)[-1]))


def fractions(values: FloatArray, limit: FloatArray) -> FloatArray:
    """Compute the fraction that each value takes of the limit on its side, shape (n, subjects)."""
    positive, negative = both_sides(limit)
    return np.asarray(np.maximum(values / positive, -values / negative), dtype=float)


def limited(machine: Machine, quantities: Quantities = QUANTITIES) -> tuple[str, ...]:
    """Names of the quantities that have a limit and can be computed."""
    return tuple(
        quantity.name
        for quantity in quantities
        if np.isfinite(quantity.limit(machine)).any() and quantity.known(machine)
    )


def evaluate(
    path: PathDynamics, sd: FloatArray, sdd: FloatArray, sddd: FloatArray, *, quantities: Quantities = QUANTITIES
) -> dict[str, FloatArray]:
    """Evaluate every quantity that can be computed, (n, subjects), for derivatives of s by time (n,)."""
    t = TimeDerivatives(sd[:, None], sdd[:, None], sddd[:, None])
    return {quantity.name: quantity.value(path, t) for quantity in quantities if quantity.known(path.machine)}


def at_rest(path: PathDynamics, quantities: Quantities = QUANTITIES) -> dict[str, FloatArray]:
    """What is left of forces however slow the motion: gravity, and dry friction while s begins to grow.

    Returns
    -------
    mapping
        Forces (n, subjects) by name; none without masses.
    """
    return {
        quantity.name: quantity.linear(path)[2]
        for quantity in quantities
        if quantity.power is None and quantity.linear is not None and quantity.known(path.machine)
    }


def moving_shares(
    path: PathDynamics, values: dict[str, FloatArray], quantities: Quantities = QUANTITIES
) -> dict[str, FloatArray]:
    """Share that motion takes of what forces at rest leave of their limits, at n places.

    With c the force at rest, F the force in motion and L its limit on that side: |F - c| / (L - c) where F is above c,
    and |F - c| / (L + c) where it is below. One is the limit itself; stretching time by f divides the share by f^2,
    however near to the limit the force at rest is.

    Parameters
    ----------
    values : mapping
        Quantities by name, evaluated for the same path dynamics.

    Returns
    -------
    mapping
        Shares (n, subjects) by the names of the forces; infinite where rest leaves no room at all.
    """
    allowed, shares = limits(path.machine, quantities), {}
    for name, rest in at_rest(path, quantities).items():
        moving, (positive, negative) = values[name] - rest, both_sides(allowed[name])
        limit = np.where(moving > 0.0, positive, negative)
        room = limit - np.sign(moving) * rest
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(room > _NO_ROOM * limit, np.abs(moving) / room, np.inf)
        shares[name] = np.where((moving == 0.0) | np.isinf(limit), 0.0, share)
    return shares
