"""Newton's and Euler's equations along a path, in series with balls: see `pipeline.machine.dynamics`.

With the pose by s, everything that depends on time is linear in sdd and sd^2: the acceleration of the pose is
x1 sdd + x2 sd^2, and its rate x1 sd.
"""

from dataclasses import dataclass

from flint import arb, arb_series

from pipeline.inclusion.closure import TERMS, Closure, Geometry, Vector, cross, dot
from pipeline.inclusion.gravity.forces import cart_weights
from pipeline.machine.dynamics import carried_cart_masses
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.masses import lumped_platform


@dataclass(frozen=True, eq=False)
class Weights:
    """What moves, in balls.

    Attributes
    ----------
    mass : arb
        The platform with load and halves of links, in kilograms.
    centre : 3
        Its centre of mass in its frame.
    inertia : 3 x 3
        Its inertia about the centre.
    gravity : 3
        Acceleration of free fall.
    carts : 3
        The carts with their halves of links, in kilograms, as their drives feel them.
    at_rest : 3
        What holds them on their rails.
    """

    mass: arb
    centre: list[arb]
    inertia: list[list[arb]]
    gravity: list[arb]
    carts: list[arb]
    at_rest: list[arb]


@dataclass(frozen=True, eq=False)
class Turning:
    """The rotation of the platform per path speed: omega = rate sd, and alpha = E a + bend sd^2."""

    rate: Vector
    bend: Vector


def weights(machine: Machine, balls: Geometry) -> Weights:
    """Convert the lumped masses of a machine with masses to balls; its floats are taken as exact.

    A cart's drive feels m |d|^2, which is m but for the rounding of d.
    """
    assert machine.masses is not None
    body = lumped_platform(machine.masses, machine.platform_points_m)
    return Weights(
        arb(body.mass_kg),
        [arb(value) for value in body.centre_m.tolist()],
        [[arb(value) for value in row] for row in body.inertia_kgm2.tolist()],
        [arb(value) for value in machine.masses.gravity_mps2.tolist()],
        [
            arb(value) * dot(rail, rail)
            for value, rail in zip(carried_cart_masses(machine.masses).tolist(), balls.rails, strict=True)
        ],
        cart_weights(balls, machine.masses),
    )


def turning(motion: Closure[arb_series], x1: Vector) -> Turning:
    """Compute how the platform turns: every axis is carried along by the rotations before it, rx, then rz, then ry."""
    x, y, z = motion.axes
    about_x = _scaled(x, x1[3])
    about_xz = _sum(about_x, _scaled(z, x1[5]))
    bend = _sum(_scaled(cross(about_x, z), x1[5]), _scaled(cross(about_xz, y), x1[4]))
    return Turning(_sum(about_xz, _scaled(y, x1[4])), bend)


def bending(motion: Closure[arb_series], x1: Vector, q1: Vector, turn: Turning, by_actuators: Vector) -> Vector:
    """Compute the right-hand side J x2 of f_l differentiated twice by s.

    With v' = x1 + omega x A' - q' d and its part a0 = alpha x A' + omega x (omega x A') of second order:
    J x2 = -V q'' - |v'|^2 - v . a0 + len'^2, where -V q'' is `by_actuators`.
    """
    right, strokes = [], iter(q1[3:])
    for link, (arm, vector) in enumerate(zip(motion.arms, motion.vectors, strict=True)):
        turned = cross(turn.rate, arm)
        cart = q1[ARM_OF_LINK[link]]
        rate = [x - cart * along for x, along in zip(_sum(x1[:3], turned), motion.rails[link], strict=True)]
        bent = _sum(cross(turn.bend, arm), cross(turn.rate, turned))
        side = by_actuators[link] - dot(rate, rate) - dot(vector, bent)
        if link in TELESCOPES:
            stroke = next(strokes)
            side = side + stroke * stroke
        right.append(side)
    return right


def wrenches(
    motion: Closure[arb_series], body: Weights, x1: Vector, x2: Vector, turn: Turning
) -> tuple[Vector, Vector, Vector]:
    """Compute force and moments about the axes of the pose: factors of sdd and sd^2, and what holds against gravity."""
    centre = [arb_series([value], prec=TERMS) for value in body.centre]
    r = [dot(row, centre) for row in motion.rotation]
    columns = [list(column) for column in zip(*motion.rotation, strict=True)]
    inertia = [[arb_series([value], prec=TERMS) for value in row] for row in body.inertia]

    def turned(vector: Vector) -> Vector:
        """Multiply by the inertia R I R'."""
        local = [dot(column, vector) for column in columns]
        local = [dot(local, row) for row in inertia]
        return [dot(row, local) for row in motion.rotation]

    def wrench(force: Vector, moment: Vector) -> Vector:
        about = _sum(cross(r, force), moment)
        return force + [dot(axis, about) for axis in motion.axes]

    def accelerated(acceleration: Vector, alpha: Vector, more: Vector) -> Vector:
        return _scaled(_sum(_sum(acceleration, cross(alpha, r)), more), body.mass)

    none = [arb_series([arb(0)], prec=TERMS)] * 3
    alpha = _about_axes(motion, x1)
    by_sdd = wrench(accelerated(x1[:3], alpha, none), turned(alpha))
    alpha = _sum(_about_axes(motion, x2), turn.bend)
    centrifugal = cross(turn.rate, cross(turn.rate, r))
    gyroscopic = _sum(turned(alpha), cross(turn.rate, turned(turn.rate)))
    by_speed = wrench(accelerated(x2[:3], alpha, centrifugal), gyroscopic)
    weight = [zero - body.mass * g for zero, g in zip(none, body.gravity, strict=True)]
    return by_sdd, by_speed, wrench(weight, none)


def _about_axes(motion: Closure[arb_series], x: Vector) -> Vector:
    a, b, c = (_scaled(axis, turn) for axis, turn in zip(motion.axes, x[3:], strict=True))
    return _sum(_sum(a, b), c)


def _sum(a: Vector, b: Vector) -> Vector:
    return [x + y for x, y in zip(a, b, strict=True)]


def _scaled(vector: Vector, factor: arb_series | arb) -> Vector:
    return [entry * factor for entry in vector]
