"""The frames that bodies move with over a whole box, in balls: along x(t), how far off they may be, and with errors."""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series

from pipeline.arrays import FloatArray
from pipeline.inclusion.bounds import actuator_ranges
from pipeline.inclusion.closure import Closure
from pipeline.inclusion.condition import above, skew
from pipeline.inclusion.following import Erring, joint_moves
from pipeline.inclusion.matrices import upper_vector
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames that hulls move with, as balls: middles and radii of their coefficients of order 0, 1 and 2 in t.

    Attributes
    ----------
    tcp, rotation : (2, orders, 3), (2, orders, 3, 3)
        TCP and R.
    origins : (2, orders, 3, 3)
        The points of the rails that the carts are at.
    rails : (3, 3)
        Directions of the rails.
    carts, platform : (2, orders, 6, 3)
        Cart joints and platform joints.
    """

    tcp: FloatArray
    rotation: FloatArray
    origins: FloatArray
    rails: FloatArray
    carts: FloatArray
    platform: FloatArray


@dataclass(frozen=True, eq=False)
class Reach:
    """How far the machine may be off its series.

    Attributes
    ----------
    shift, turn : float
        Bounds of how far the pose is off: its place, and the sum of its angles.
    platform, carts : (6,)
        Bounds of how far platform joints and cart joints are off.
    origins, rails : (3,)
        The same of the points of the rails that carts are at, and of rails.
    lengths : (6, 2)
        Least and largest length of each link, with all errors.
    errors_m : (5,)
        Bounds of the errors of the actuators.
    """

    shift: float
    turn: float
    platform: FloatArray
    carts: FloatArray
    origins: FloatArray
    rails: FloatArray
    lengths: FloatArray
    errors_m: FloatArray


@dataclass(frozen=True, eq=False)
class Moves:
    """How frames move with the error of each actuator, as balls: middles and radii.

    Attributes
    ----------
    tcp, turning : (2, 5, 3), (2, 5, 3, 3)
        dp/de, and dR/de.
    carts, platform : (2, 5, 6, 3)
        The same of cart joints and platform joints.
    """

    tcp: FloatArray
    turning: FloatArray
    carts: FloatArray
    platform: FloatArray


def frames_along(box: ProvenBox) -> Frames:
    """Place the frames along x(t)."""
    closures = (box.series.at, box.series.at, box.series.over)
    return Frames(
        tcp=_balls([[x[k] for x in one.pose[:3]] for k, one in enumerate(closures)]),
        rotation=_balls([[[x[k] for x in row] for row in one.rotation] for k, one in enumerate(closures)]),
        origins=_balls([_origins(box, one, k) for k, one in enumerate(closures)]),
        rails=box.machine.rail_directions,
        carts=_balls([_cart_joints(box, one, k) for k, one in enumerate(closures)]),
        platform=_balls([_platform_joints(one, k) for k, one in enumerate(closures)]),
    )


def reach_of(box: ProvenBox) -> Reach:
    """Bound how far frames may be off, for all poses, errors and machines that a box holds for."""
    errors, off = upper_vector(box.inclusion.following.errors), box.displacement
    lengths = np.repeat(np.asarray(box.machine.lengths_m)[:, None], 2, axis=1)
    lengths[TELESCOPES] = actuator_ranges(box)[3:]
    if box.inclusion.following.any:
        spread = errors[3:, None] * [-1.0, 1.0]
        lengths[TELESCOPES] = np.nextafter(lengths[TELESCOPES] + spread, [-np.inf, np.inf])
    if box.ellipsoid is not None:
        spread = np.array([above(longer) for longer in off.lengths])[:, None] * [-1.0, 1.0]
        lengths = np.nextafter(lengths + spread, [-np.inf, np.inf])
    return Reach(
        shift=above(off.shift),
        turn=above(off.turn),
        platform=np.array([above(one) for one in off.platform]),
        carts=np.array([above(one) for one in off.carts]),
        origins=np.array([above(one) for one in off.origins]),
        rails=np.array([above(one) for one in off.rails]),
        lengths=lengths,
        errors_m=errors if box.inclusion.following.any else np.zeros(len(ACTUATORS)),
    )


def moves_by_errors(errors: Erring) -> Moves:
    """Enclose how frames move: with the axes E of the angles, dR/de = (E P_angles) x R."""
    P, hull = errors.following.over, errors.hull
    shift, turn = (np.array(P.table(), dtype=object)[rows] for rows in (slice(0, 3), slice(3, 6)))
    spins = (arb_mat(hull.axes).transpose() * arb_mat(turn.tolist())).transpose().table()
    R, joints = arb_mat(hull.rotation), _balls([move.transpose().table() for move in joint_moves(errors)])
    links = len(hull.arms)
    return Moves(
        tcp=_balls(shift.T.tolist()),
        turning=_balls([(skew(spin) * R).table() for spin in spins]),
        carts=joints[:, :, :links],
        platform=joints[:, :, links : 2 * links],
    )


def _origins(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[arm][order] * along + arb(c) * constant for along, c in zip(rail, (0.0, *place), strict=True)]
        for arm, (rail, place) in enumerate(zip(box.balls.rails, box.machine.rails_m.tolist(), strict=True))
    ]


def _cart_joints(box: ProvenBox, closure: Closure[arb_series], order: int) -> list[list[arb]]:
    constant = arb(int(order == 0))
    return [
        [closure.q[arm][order] * along + c * constant for along, c in zip(box.balls.rails[arm], anchor, strict=True)]
        for arm, anchor in zip(ARM_OF_LINK, box.balls.anchors, strict=True)
    ]


def _platform_joints(closure: Closure[arb_series], order: int) -> list[list[arb]]:
    return [[p[order] + a[order] for p, a in zip(closure.pose, arm, strict=False)] for arm in closure.arms]


def _balls(table: object) -> FloatArray:
    """Turn nested lists of balls into middles and radii, stacked; radii include what the middles are rounded by."""
    entries = np.array(table, dtype=object)
    middle = np.array([float(entry.mid()) for entry in entries.ravel()])
    radius = np.array(
        [above((entry - arb(value)).abs_upper()) for entry, value in zip(entries.ravel(), middle.tolist(), strict=True)]
    )
    return np.stack([middle.reshape(entries.shape), radius.reshape(entries.shape)])
