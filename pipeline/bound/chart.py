"""One smooth chart of all assembled poses, through every change of working mode.

With the right-angled triangle u_3a . (R w) = 0. Where w has no component along y, and with R = Q Ry(ry), Q = Rx Rz,

    Q^T u_3a = (cos(beta) cos(alpha), sin(beta), cos(beta) sin(alpha)),    alpha + ry = psi,

psi an angle of the machine. In the frame P = Q Ry(-alpha), u_3a = (cos(beta), sin(beta), 0), and the platform's joints
are constants, Ry(psi) a_l. Coordinates are alpha, beta, rx, rz and the components s_1, s_2 of v_1, v_2a along X, whose
signs are the working modes; that of arm 3 is the sign of u_3a,x. They are tied by s_k^2 = D_k: smooth where D_k = 0.

alpha comes round after a full turn. At beta = +-90 degrees the triangle folds, and the machine may change to the other
of its two assemblies; what touches these faces of the chart is treated as connected.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.bound.forms import Form, constant, coordinate, cosine_sine, joined, sum_of
from pipeline.machine.geometry import ARM_OF_LINK, PRIMARY, TRIANGLE, Machine, link_vectors, rotation_x, rotation_z
from pipeline.machine.pose import RY
from pipeline.machine.triangle import on_axis
from pipeline.route.regions.endpoints import Endpoint

NAMES = ("alpha", "beta", "rx", "rz", "s1", "s2")
ALPHA, BETA = 0, 1
_HALF_TURN, _RIGHT_ANGLE = 3.1415926535897936, 1.5707963267948968
"""Just above pi and pi / 2."""
_ROUNDED = 1e-15
"""More than a coordinate, a joint or a length in metres is off by rounding."""
_LINKS = 6


@dataclass(frozen=True, eq=False)
class Chart:
    """The chart of a machine for a task.

    Attributes
    ----------
    low, high : (6,)
        The domain; equal where a coordinate is fixed.
    joints_m : (6, 3)
        Platform joints in the frame P, Ry(psi) a_l.
    bases_m : (6, 3)
        Cart joints from that of link 3a, in the world; along X only from the origin of their carts.
    machine : Machine
    """

    low: FloatArray
    high: FloatArray
    joints_m: FloatArray
    bases_m: FloatArray
    machine: Machine

    @property
    def free(self) -> list[int]:
        """Coordinates that are not fixed; those of tilts may be."""
        return [k for k in range(len(NAMES)) if self.high[k] > self.low[k]]


@dataclass(frozen=True, eq=False)
class Frame:
    """What follows from the four angles of boxes.

    Attributes
    ----------
    P : Form
        (3, 3, n): the frame's axes are its columns.
    u3 : Form
        (3, n): link 3a in the frame.
    across : Form
        (2, 3, n): A_k - C_3a in the world, for links 1 and 2a, with y and z from C_k.
    D : Form
        (2, n): s_k^2.
    """

    P: Form
    u3: Form
    across: Form
    D: Form


@dataclass(frozen=True, eq=False)
class Links:
    """Vectors of all links in the frame P (6, 3, n), carts 1 and 2 from cart 3 (2, n), D_k - s_k^2 (2, n)."""

    v: Form
    carts: Form
    mismatch: Form


def why_no_chart(machine: Machine, right_angled: bool) -> str:
    """Say why a machine has no chart of this kind; empty if it has one."""
    points, offsets = machine.platform_points_m, machine.cart_offsets_m
    if not on_axis(machine):
        return "joint 3a is not on the platform's y axis (machine.links.l3a.platform_point_m)"
    if not right_angled:
        return "the triangle has no right angle at the platform (machine.links.l3c.length_m is given)"
    if not np.array_equal(offsets[PRIMARY[2]], offsets[TRIANGLE]):
        return "links 3a and 3c have different joints on cart 3 (cart_offset_m)"
    if points[PRIMARY[2], 1] != points[TRIANGLE, 1]:
        return "the platform side of the triangle is not at a right angle to the platform's y axis"
    return ""


def build_chart(machine: Machine, tilt_max_rad: tuple[float, float], ends: tuple[Endpoint, Endpoint]) -> Chart:
    """Make the chart of a machine that has one, for tilts rx and rz up to the given ones.

    alpha begins and ends as far from both ends of the task as can be.
    """
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[PRIMARY[2]]
    c, s = machine.triangle_sign * np.array([w[2], -w[0]]) / np.hypot(w[0], w[2])
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    joints = machine.platform_points_m @ turn.T
    carts = machine.cart_offsets_m + np.column_stack([np.zeros(3), machine.rails_m])[ARM_OF_LINK]
    chart = Chart(np.zeros(6), np.zeros(6), joints, carts - carts[PRIMARY[2]], machine)
    angles = [float(chart_point(chart, end)[ALPHA]) for end in ends]
    apart = (angles[1] - angles[0] + np.pi) % (2.0 * np.pi) - np.pi
    middle = angles[0] + 0.5 * apart
    reach = machine.lengths_m[PRIMARY[:2]]
    half = np.array([_HALF_TURN, _RIGHT_ANGLE, *tilt_max_rad, *reach])
    centre = np.array([middle, 0.0, 0.0, 0.0, 0.0, 0.0])
    return Chart(centre - half, centre + half, joints, chart.bases_m, machine)


def chart_point(chart: Chart, end: Endpoint) -> FloatArray:
    """Compute the coordinates (6,) of a pose, in floats; alpha is within a turn of the domain's lower end."""
    pose = end.pose
    v = link_vectors(chart.machine, pose, end.q_m[:3])
    Q = rotation_x(pose[3]) @ rotation_z(pose[5])
    u = Q.T @ v[PRIMARY[2]] / chart.machine.lengths_m[PRIMARY[2]]
    w = chart.machine.platform_points_m[TRIANGLE] - chart.machine.platform_points_m[PRIMARY[2]]
    psi = np.arctan2(-chart.machine.triangle_sign * w[0], chart.machine.triangle_sign * w[2])
    alpha = psi - pose[RY]
    beta = np.arctan2(u[1], u[0] * np.cos(alpha) + u[2] * np.sin(alpha))
    low = chart.low[ALPHA]
    return np.array([low + (alpha - low) % (2.0 * np.pi), beta, pose[3], pose[5], v[PRIMARY[0], 0], v[PRIMARY[1], 0]])


def frame(chart: Chart, low: FloatArray, high: FloatArray) -> Frame:
    """Evaluate what follows from the angles of boxes (6, n)."""
    symbols = _symbols(chart)
    N, n = len(symbols), low.shape[1]
    trig = []
    for k in range(4):
        middle, half = _middle_half(low[k], high[k])
        trig.append(cosine_sine(middle, half, symbols.get(k), N))
    (ca, sa), (cb, sb), (cx, sx), (cz, sz) = trig
    zero = constant(np.zeros(n), N)
    ex = [cz, cx * sz, sx * sz]
    ey = [-sz, cx * cz, sx * cz]
    ez = [zero, -sx, cx]
    first = [ca * a + sa * b for a, b in zip(ex, ez, strict=True)]
    third = [ca * b - sa * a for a, b in zip(ex, ez, strict=True)]
    P = joined([joined([first[i], ey[i], third[i]]) for i in range(3)])
    length = float(chart.machine.lengths_m[PRIMARY[2]])
    u3 = joined([cb, sb, zero])
    world = [(first[i] * cb + ey[i] * sb).times(length) for i in range(3)]
    across = []
    for link in PRIMARY[:2].tolist():
        arm = chart.joints_m[link] - chart.joints_m[PRIMARY[2]]
        base = chart.bases_m[link] * [0.0, 1.0, 1.0]
        parts = [
            (world[i] + P[i, 0].times(arm[0]) + P[i, 1].times(arm[1]) + P[i, 2].times(arm[2])).plus(-base[i])
            for i in range(3)
        ]
        across.append(joined(parts))
    both = _loosened(joined(across), 4.0 * _ROUNDED)
    y, z = both[:, 1], both[:, 2]
    squares = np.repeat(chart.machine.lengths_m[PRIMARY[:2], None] ** 2, n, axis=1)
    D = constant(squares, N, 4.0 * _ROUNDED) - y * y - z * z
    return Frame(P, u3, both, D)


def links(chart: Chart, at: Frame, low: FloatArray, high: FloatArray) -> Links:
    """Evaluate all link vectors of boxes (6, n)."""
    symbols = _symbols(chart)
    N, n = len(symbols), low.shape[1]
    P = at.P
    s = joined([coordinate(*_middle_half(low[k], high[k]), symbols.get(k), N) for k in (4, 5)])
    mismatch = at.D - s * s
    carts = at.across[:, 0] - s
    third = at.u3.times(float(chart.machine.lengths_m[PRIMARY[2]]))
    v: dict[int, Form] = {int(PRIMARY[2]): third}
    for k, link in enumerate(PRIMARY[:2].tolist()):
        # A - C = (A - C_3a) - (C - C_3a), and only the cart's place along X is not constant.
        arm = (chart.joints_m[link] - chart.joints_m[PRIMARY[2]])[:, None]
        base = np.repeat(chart.bases_m[link][:, None], n, axis=1)
        there = joined([carts[k], constant(base[1], N), constant(base[2], N)])
        back = joined([sum_of([P[i, j] * there[i] for i in range(3)]) for j in range(3)])
        v[link] = third.plus(arm) - back
    for link in range(_LINKS):
        if link not in v:
            beside = int(PRIMARY[ARM_OF_LINK[link]])
            arm = (chart.joints_m[link] - chart.joints_m[beside])[:, None]
            base = chart.machine.cart_offsets_m[link] - chart.machine.cart_offsets_m[beside]
            back = joined([sum_of([P[i, j].times(base[i]) for i in range(3)]) for j in range(3)])
            v[link] = v[beside].plus(arm) - back
    everything = _loosened(joined([v[link] for link in range(_LINKS)]), 8.0 * _ROUNDED)
    offset = chart.machine.cart_offsets_m[PRIMARY, 0]
    return Links(everything, carts.plus((offset[2] - offset[:2])[:, None]), mismatch)


def _symbols(chart: Chart) -> dict[int, int]:
    return {k: symbol for symbol, k in enumerate(chart.free)}


def _middle_half(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    fixed = low == high
    half = np.where(fixed, 0.0, 0.5 * (high - low) * (1.0 + 1e-14) + 8.0 * _ROUNDED)
    return 0.5 * (low + high), half


def _loosened(form: Form, error: float) -> Form:
    """Allow for constants of the machine that are rounded."""
    return Form(form.c, form.g, form.e + error, form.size + error)
