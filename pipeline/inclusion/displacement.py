"""How far the parts of a machine may be from where they are along x(t): for bounds of limits over a box.

With poses x(t) + d, |d_i| at most a deviation, no Euler angle moves a joint farther than its distance from the TCP
times the angle. For the machines of an ellipsoid the pose is x - C (V u + q) + d, and with T_l = [axes x A'_l] over
all poses of the box a platform joint moves by

    [1, T_l] (-C V u) + R da_l + [1, T_l] (d - C q),

so that what u does to a joint is one matrix, and the first two parts are at most k times its norm.
"""

from dataclasses import dataclass

from flint import arb, arb_mat

from pipeline.inclusion.calibrated.closures import (
    along_x,
    first_order,
    length_of,
    link_changes,
    norm_of,
    row_norms,
    second_order,
)
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.closure import Closure, Geometry, closure, cross
from pipeline.inclusion.krawczyk import Inclusion, Piecewise
from pipeline.inclusion.matrices import added, ball_matrix, magnitudes, times


@dataclass(frozen=True, eq=False)
class Displacement:
    """Bounds of how far parts are from where x(t) and the configured machine have them.

    Attributes
    ----------
    pose : 6 bounds
        Of every coordinate of the pose.
    shift, turn : bounds
        Of the TCP, and of the platform's orientation: the sum of its angles.
    platform, carts : 6 bounds each
        Of platform joints and cart joints.
    arms, vectors, lengths : 6 bounds each
        Of A'_l, v_l and len_l.
    origins, rails : 3 bounds each
        Of the points of the rails that the carts are at, and of the rails as lines.
    actuators : 5 bounds
        Of carts and telescopes.
    moves : 15 matrices 3 x m, or none
        Of cart joints, platform joints and rails, in this order: what u / k does to them; and
    rest : 15 bounds
        of what else moves them.
    """

    pose: list[arb]
    shift: arb
    turn: arb
    platform: list[arb]
    carts: list[arb]
    arms: list[arb]
    vectors: list[arb]
    lengths: list[arb]
    origins: list[arb]
    rails: list[arb]
    actuators: list[arb]
    moves: list[arb_mat]
    rest: list[arb]


def of_pose(machine: Geometry, deviation: list[arb]) -> Displacement:
    """Bound displacements of the configured machine whose pose is off by up to `deviation` (6,)."""
    shift, turn = length_of(deviation[:3]), sum((d.abs_upper() for d in deviation[3:]), arb(0))
    arms = [length_of(point) * turn for point in machine.points]
    platform = [shift + arm for arm in arms]
    none = [arb(0)] * len(machine.points)
    rest = [*none, *platform, *none[:3]]
    return Displacement(
        deviation, shift, turn, platform, none, arms, platform, none, none[:3], none[:3], none[:5], [], rest
    )


def of_machines(machine: Geometry, series: Piecewise, inclusion: Inclusion, ellipsoid: Ellipsoid) -> Displacement:
    """Bound displacements of all machines of an ellipsoid, for a box that was proven for them."""
    over, k = series.over, arb(ellipsoid.sigma)
    changes = link_changes(ellipsoid, [q[0] for q in over.q])
    C = ball_matrix(inclusion.inverse[0]) + ball_matrix(inclusion.inverse[1]) * arb(0, series.half)
    moved = -(C * first_order(over, changes))
    rest = times(magnitudes(C), second_order(over, changes, ellipsoid.sigma))
    rest = added(rest, [arb(r) for r in inclusion.box.radius.tolist()])
    hull = _hull(machine, series, added(rest, [k * size for size in row_norms(moved)]))
    R, own = arb_mat(hull.rotation), of_pose(machine, rest)
    pose = [k * size + more for size, more in zip(row_norms(moved), rest, strict=True)]
    shift, turn = arb_mat(moved.table()[:3]), arb_mat(moved.table()[3:])
    arms, vectors, moves = [], [], []
    for link, arm in enumerate(hull.arms):
        turned = arb_mat([cross(axis, arm) for axis in hull.axes]).transpose() * turn + R * changes.points[link]
        arms.append(k * norm_of(turned) + own.arms[link])
        moves.append(shift + turned)
        vectors.append(k * norm_of(shift + turned - changes.joints[link]) + own.vectors[link])
    carts = [rail + along_x(row) for rail, row in zip(ellipsoid.rows.rails, changes.actuators, strict=False)]
    return Displacement(
        pose=pose,
        shift=k * norm_of(shift) + own.shift,
        turn=sum(pose[3:], arb(0)),
        platform=[k * norm_of(move) + more for move, more in zip(moves, own.platform, strict=True)],
        carts=[k * norm_of(joint) for joint in changes.joints],
        arms=arms,
        vectors=vectors,
        lengths=[k * norm_of(length) for length in changes.lengths],
        origins=[k * norm_of(cart) for cart in carts],
        rails=[k * norm_of(rail) for rail in ellipsoid.rows.rails],
        actuators=[k * norm_of(row) for row in changes.actuators],
        moves=[part * k for part in (*changes.joints, *moves, *ellipsoid.rows.rails)],
        rest=own.rest,
    )


def _hull(machine: Geometry, series: Piecewise, reach: list[arb]) -> Closure[arb]:
    """Evaluate the closures of the configured machine over all poses of a box."""
    pose = [coordinate[0] + arb(0, r.upper()) for coordinate, r in zip(series.over.pose, reach, strict=True)]
    return closure(machine, pose, [q[0] for q in series.over.q])
