"""Newton's and Euler's equations along the cubics of many boxes, as series with orders first and boxes last.

The statement is that of `pipeline.machine.dynamics`; everything by time is linear in sdd and sd^2, the second
derivative of s by time and its speed squared. Axes of the pose's coordinates are E = (e_x, y_platform, Rx e_z).
"""

from dataclasses import dataclass
from functools import partial
from operator import mul

import numpy as np

from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, cross, dot, exactly, stacked
from pipeline.certify.recheck.arithmetic.jets import product
from pipeline.certify.recheck.arithmetic.motion import Motion, along_rails, on_rails
from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.masses import Masses, lumped_platform

Series = Enclosure


@dataclass(frozen=True, eq=False)
class Rates:
    """How links and platform move per path speed, and accelerate per its square with x2 left out.

    Attributes
    ----------
    omega, bend : (orders, 3, n)
        Angular velocity, and the part of the angular acceleration that x1 makes.
    vectors, bends : (orders, 6, 3, n)
        Velocities of the links' vectors, and that part of their accelerations.
    """

    omega: Series
    bend: Series
    vectors: Series
    bends: Series


def derivative(coefficients: Enclosure, order: int) -> Enclosure:
    """Differentiate polynomials, coefficients first."""
    for _ in range(order):
        powers = np.arange(1.0, len(coefficients.mid)).reshape(-1, *[1] * (coefficients.mid.ndim - 1))
        coefficients = coefficients[1:] * exactly(powers)
    return coefficients


def rates(motion: Motion, x1: Series, q1: Series) -> Rates:
    """Compute the rates for the derivatives of pose (orders, 6, n) and actuators (orders, 5, n) by s."""
    (x, y, z), (rx, ry, rz) = ([motion.axes[:, k] for k in range(3)], [x1[:, k] for k in (3, 4, 5)])
    about_x = _scaled(x, rx)
    about_xz = about_x + _scaled(z, rz)
    omega, bend = about_xz + _scaled(y, ry), _scaled(_cross(about_x, z), rz) + _scaled(_cross(about_xz, y), ry)
    turned = _crossed(omega, motion.arms)
    vectors = Enclosure(x1.mid[:, None, :3], x1.rad[:, None, :3]) + turned
    along = on_rails(q1[:, ARM_OF_LINK], motion.rails)
    return Rates(omega, bend, vectors - along, _crossed(bend, motion.arms) + _crossed(omega, turned))


def by_actuators(motion: Motion, q: Series) -> Series:
    """Compute -V q' for derivatives of the actuators (orders, 5, n), shape (orders, 6, n)."""
    found = product(mul, along_rails(motion.vectors, motion.rails), q[:, ARM_OF_LINK])
    strokes = product(mul, motion.lengths[:, TELESCOPES], q[:, 3:])
    return _added_at(found, strokes)


def bending(motion: Motion, found: Rates, q1: Series, forced: Series) -> Series:
    """Compute J x2: -V q'' less |v'|^2 and v . a0, and len'^2 of telescopes."""
    squares = product(partial(dot, axis=1), found.vectors, found.vectors)
    bent = product(partial(dot, axis=1), motion.vectors, found.bends)
    return _added_at(forced - squares - bent, product(mul, q1[:, 3:], q1[:, 3:]))


def wrenches(machine: Machine, motion: Motion, x1: Series, x2: Series, found: Rates) -> tuple[Series, Series, Series]:
    """Compute force and moments about the axes, (orders, 6, n): factors of sdd and sd^2, and those at rest."""
    assert machine.masses is not None
    body, gravity = lumped_platform(machine.masses, machine.platform_points_m), machine.masses.gravity_mps2
    mass = exactly(body.mass_kg)
    r = contract("oijn,j->oin", motion.rotation, exactly(body.centre_m), 3)
    inertia = exactly(body.inertia_kgm2)

    def turned(vector: Series) -> Series:
        local = product(partial(contract, "jin,jn->in", terms=3), motion.rotation, vector)
        return product(partial(_matrix_times, terms=3), motion.rotation, contract("ij,ojn->oin", inertia, local, 3))

    def wrench(force: Series, moment: Series) -> Series:
        about = _cross(r, force) + moment
        turns = product(partial(_matrix_times, terms=3), motion.axes, about)
        return Enclosure(np.concatenate([force.mid, turns.mid], 1), np.concatenate([force.rad, turns.rad], 1))

    alpha = _about_axes(motion, x1)
    by_sdd = wrench((x1[:, :3] + _cross(alpha, r)) * mass, turned(alpha))
    alpha = _about_axes(motion, x2) + found.bend
    centrifugal = _cross(found.omega, _cross(found.omega, r))
    gyroscopic = turned(alpha) + _cross(found.omega, turned(found.omega))
    by_speed = wrench((x2[:, :3] + _cross(alpha, r) + centrifugal) * mass, gyroscopic)
    weight, none = np.zeros_like(r.mid), exactly(np.zeros_like(r.mid))
    weight[0] = -gravity[:, None]
    return by_sdd, by_speed, wrench(exactly(weight) * mass, none)


def forces(machine: Machine, motion: Motion, g: Series, moved: Series | None) -> Series:
    """Compute the forces of drives and links (orders, 11, n) from those of links by length, and the carts' motion."""
    assert machine.masses is not None
    links = product(mul, g, motion.lengths)
    along = product(mul, g, along_rails(motion.vectors, motion.rails))
    drives, masses = [], _felt_masses(machine, machine.masses)
    at_rest = cart_weights(machine, machine.masses)
    for arm in range(len(machine.rails_m)):
        on_cart = np.flatnonzero(arm == ARM_OF_LINK)
        force = along[:, on_cart[0]]
        for link in on_cart[1:]:
            force = force + along[:, link]
        if moved is None:
            drives.append(with_constant(force, at_rest[arm]))
        else:
            drives.append(force + moved[:, arm] * masses[arm])
    return stacked([*drives, *(links[:, k] for k in TELESCOPES), *(links[:, k] for k in range(6))], 1)


def cart_weights(machine: Machine, masses: Masses) -> Enclosure:
    """Enclose what holds the carts on their rails, -m g . d. Shape (3,)."""
    along = contract("kc,c->k", exactly(machine.rail_directions), exactly(-masses.gravity_mps2), 3)
    return along * exactly(carried_cart_masses(masses))


def with_constant(series: Series, constant: Enclosure) -> Series:
    """Add a number to series (orders, n)."""
    mid, rad = np.zeros_like(series.mid), np.zeros_like(series.rad)
    mid[0], rad[0] = constant.mid, constant.rad
    return series + Enclosure(mid, rad)


def _felt_masses(machine: Machine, masses: Masses) -> Enclosure:
    """Enclose the carts' masses as their drives feel them, m |d|^2. Shape (3,)."""
    d = exactly(machine.rail_directions)
    return contract("kc,kc->k", d, d, 3) * exactly(carried_cart_masses(masses))


def _matrix_times(a: Enclosure, b: Enclosure, terms: int) -> Enclosure:
    return contract("ijn,jn->in", a, b, terms)


def _cross(a: Series, b: Series) -> Series:
    return product(partial(cross, axis=0), a, b)


def _crossed(a: Series, b: Series) -> Series:
    """Multiply a vector (orders, 3, n) by those of the links (orders, 6, 3, n)."""
    wide = Enclosure(np.repeat(a.mid[:, None], 6, 1), np.repeat(a.rad[:, None], 6, 1))
    return product(partial(cross, axis=1), wide, b)


def _scaled(vector: Series, factor: Series) -> Series:
    return product(mul, vector, factor[:, None])


def _about_axes(motion: Motion, x: Series) -> Series:
    parts = [_scaled(motion.axes[:, k], x[:, 3 + k]) for k in range(3)]
    return parts[0] + parts[1] + parts[2]


def _added_at(series: Series, strokes: Series) -> Series:
    """Add series of the telescopes (orders, 2, n) to those of all links (orders, 6, n)."""
    mid, rad = (np.zeros_like(series.mid) for _ in range(2))
    mid[:, TELESCOPES], rad[:, TELESCOPES] = strokes.mid, strokes.rad
    return series + Enclosure(mid, rad)
