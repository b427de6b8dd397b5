"""What the machines of an ellipsoid change of the closures.

A cart joint moves by dC_l = db_l + d(rail) + (dz_k + n_k ds_k) e_x, a platform joint by R da_l, and a length by dlen_l,
all linear in u. With w_l = R da_l - dC_l, f_l changes by

    v_l . w_l - len_l dlen_l + |w_l|^2 / 2 - dlen_l^2 / 2 = V_l u + q_l,

of which the first part is at most k |V_l|.
"""

from dataclasses import dataclass

from flint import arb, arb_mat, arb_series

from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.closure import Closure, cross
from pipeline.inclusion.matrices import magnitudes, times
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES

OFF_X = "the machines of an ellipsoid have rails along X"
_LINKS = 6
_TELESCOPE = {int(link): 3 + k for k, link in enumerate(TELESCOPES)}


@dataclass(frozen=True, eq=False)
class LinkChanges:
    """What u changes of the links at some q, as matrices of m columns.

    Attributes
    ----------
    points, joints : 6 matrices 3 x m
        da_l in the platform frame, and dC_l.
    lengths : 6 matrices 1 x m
        dlen_l.
    actuators : 5 matrices 1 x m
        Of carts and telescopes.
    """

    points: list[arb_mat]
    joints: list[arb_mat]
    lengths: list[arb_mat]
    actuators: list[arb_mat]


def link_changes(ellipsoid: Ellipsoid, q: list[arb]) -> LinkChanges:
    """Enclose what u changes where actuators are at q (5,), in balls."""
    rows = ellipsoid.rows
    at = zip(q, ellipsoid.zero_at_m.tolist(), ellipsoid.scale.tolist(), strict=True)
    shown = [(position - zero) / scale for position, zero, scale in at]
    actuators = [zero + scale * n for zero, scale, n in zip(rows.zeros, rows.scales, shown, strict=True)]
    joints, lengths = [], []
    for link, (anchor, fixed) in enumerate(zip(rows.anchors, rows.lengths, strict=True)):
        joints.append(anchor + along_x(actuators[int(ARM_OF_LINK[link])]))
        lengths.append(actuators[_TELESCOPE[link]] if fixed is None else fixed)
    return LinkChanges(rows.points, joints, lengths, actuators)


def along_x(row: arb_mat) -> arb_mat:
    """Make a row (1, m) the x of three coordinates."""
    none = [arb(0)] * row.ncols()
    return arb_mat([row.entries(), none, none])


def first_order(over: Closure[arb_series], changes: LinkChanges) -> arb_mat:
    """Enclose V over an interval, 6 x m."""
    R = arb_mat([[entry[0] for entry in row] for row in over.rotation])
    rows = []
    for link in range(_LINKS):
        v = arb_mat([[entry[0] for entry in over.vectors[link]]])
        row = v * (R * changes.points[link] - changes.joints[link]) - changes.lengths[link] * over.lengths[link][0]
        rows.append(row.entries())
    return arb_mat(rows)


def second_order(over: Closure[arb_series], changes: LinkChanges, sigma: float) -> list[arb]:
    """Bound q. Six bounds in square metres."""
    R, k = arb_mat([[entry[0] for entry in row] for row in over.rotation]), arb(sigma)
    apart = [R * point - joint for point, joint in zip(changes.points, changes.joints, strict=True)]
    return [
        ((k * norm_of(w)) ** 2 + (k * norm_of(longer)) ** 2) / 2
        for w, longer in zip(apart, changes.lengths, strict=True)
    ]


def residual_change(over: Closure[arb_series], ellipsoid: Ellipsoid) -> list[arb]:
    """Bound E, the change of the closures at the poses x(t). Six bounds in square metres.

    Raises
    ------
    ValueError
        If a rail is off X.
    """
    if not all(y.is_zero() and z.is_zero() for _, y, z in over.rails):
        raise ValueError(OFF_X)
    changes, k = link_changes(ellipsoid, [q[0] for q in over.q]), arb(ellipsoid.sigma)
    second = second_order(over, changes, ellipsoid.sigma)
    return [k * size + more for size, more in zip(row_norms(first_order(over, changes)), second, strict=True)]


def preconditioned_change(hull: Closure[arb], C: arb_mat, ellipsoid: Ellipsoid) -> list[list[arb]]:
    """Bound |C dJ|, with dJ the change of f_l' over all poses of a box. 6 x 6 bounds.

    All links together: what changes several rows of J alike may hardly change C J. By a coordinate of the TCP f_l'
    changes by w, by the angle about an axis by (axis x A') . w + (v x axis) . R da, both linear in u, and by
    w . (axis x R da).
    """
    changes, k, R = link_changes(ellipsoid, hull.q), arb(ellipsoid.sigma), arb_mat(hull.rotation)
    turned = [R * point for point in changes.points]
    w = [point - joint for point, joint in zip(turned, changes.joints, strict=True)]
    tables = [part.table() for part in w]
    columns = [arb_mat([table[axis] for table in tables]) for axis in range(3)]
    for axis in hull.axes:
        rows = [
            arb_mat([cross(axis, hull.arms[link])]) * w[link]
            + arb_mat([cross(hull.vectors[link], axis)]) * turned[link]
            for link in range(_LINKS)
        ]
        columns.append(arb_mat([row.entries() for row in rows]))
    second = times(
        magnitudes(C), [k * norm_of(one) * k * norm_of(other) for one, other in zip(w, changes.points, strict=True)]
    )
    found = [[k * size for size in row_norms(C * column)] for column in columns]
    angles = [[size + more for size, more in zip(column, second, strict=True)] for column in found[3:]]
    return [list(row) for row in zip(*found[:3], *angles, strict=True)]


def norm_of(matrix: arb_mat) -> arb:
    """Bound ||M||_2 of a matrix with few rows: ||M||^2 = ||M M'||, at most its Frobenius norm."""
    square = matrix * matrix.transpose()
    total = sum((entry.abs_upper() ** 2 for entry in square.entries()), arb(0))
    return total.sqrt().sqrt().abs_upper()


def row_norms(matrix: arb_mat) -> list[arb]:
    """Bound the Euclidean norm of every row."""
    return [length_of(row) for row in magnitudes(matrix)]


def length_of(vector: list[arb]) -> arb:
    """Bound the Euclidean norm of a vector."""
    return sum((entry.abs_upper() ** 2 for entry in vector), arb(0)).sqrt().abs_upper()
