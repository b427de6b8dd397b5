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

from pipeline.arrays import FloatArray, IntArray
from pipeline.bound.forms import Form, constant, coordinate, cosine_sine, joined, sum_of
from pipeline.machine.geometry import (
    ARM_OF_LINK,
    PRIMARY,
    TELESCOPES,
    TRIANGLE,
    Machine,
    link_vectors,
    rotation_x,
    rotation_z,
)
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

    def boxes(self, keep: IntArray) -> "Frame":
        """Select boxes (m,)."""
        return Frame(*(part.boxes(keep) for part in (self.P, self.u3, self.across, self.D)))


@dataclass(frozen=True, eq=False)
class Links:
    """The links of boxes, in the world.

    Attributes
    ----------
    v : Form
        (6, 3, n): A_l - C_l.
    arms : Form
        (6, 3, n): from the TCP to A_l, R a_l.
    squares : Form
        (2, n): squared lengths of the telescopes.
    apart : Form
        (3, n): carts 1 and 2 from cart 3, and cart 1 from cart 2.
    ties : Form
        (2, n): D_k - s_k^2.
    """

    v: Form
    arms: Form
    squares: Form
    apart: Form
    ties: Form

    def boxes(self, keep: IntArray) -> "Links":
        """Select boxes (m,)."""
        return Links(*(part.boxes(keep) for part in (self.v, self.arms, self.squares, self.apart, self.ties)))


def why_no_chart(machine: Machine, right_angled: bool) -> str:
    """Say why a machine has no chart of this kind; empty if it has one."""
    points, offsets = machine.platform_points_m, machine.cart_offsets_m
    if not machine.has_parallel_rails:
        return "the chart leaves out x, which plays a role where rails are not parallel (machine.rails.slopes)"
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
    u3 = joined([first[i] * cb + ey[i] * sb for i in range(3)])
    link = u3.times(float(chart.machine.lengths_m[PRIMARY[2]]))
    across = []
    for k in PRIMARY[:2].tolist():
        arm, base = chart.joints_m[k] - chart.joints_m[PRIMARY[2]], chart.bases_m[k] * [0.0, 1.0, 1.0]
        across.append((link + _turned(P, arm)).plus(-base[:, None]))
    both = _loosened(joined(across), 4.0 * _ROUNDED)
    y, z = both[:, 1], both[:, 2]
    squares = np.repeat(chart.machine.lengths_m[PRIMARY[:2], None] ** 2, n, axis=1)
    D = constant(squares, N, 4.0 * _ROUNDED) - y * y - z * z
    return Frame(P, u3, both, D)


def links(chart: Chart, at: Frame, low: FloatArray, high: FloatArray) -> Links:
    """Evaluate all links of boxes (6, n).

    Telescopes are beside links 2a and 3a, of fixed length L: with a and c the sides on platform and cart,
    |v + R a - c|^2 = L^2 + a^2 + c^2 + 2 v . (R a - c) - 2 c . R a.
    """
    symbols, machine = _symbols(chart), chart.machine
    N = len(symbols)
    s = joined([coordinate(*_middle_half(low[k], high[k]), symbols.get(k), N) for k in (4, 5)])
    v: dict[int, Form] = {int(PRIMARY[2]): at.u3.times(float(machine.lengths_m[PRIMARY[2]]))}
    for k, link in enumerate(PRIMARY[:2].tolist()):
        v[link] = joined([s[k], at.across[k, 1], at.across[k, 2]])
    squares = []
    for link in (*TELESCOPES.tolist(), TRIANGLE):
        beside = int(PRIMARY[ARM_OF_LINK[link]])
        a = chart.joints_m[link] - chart.joints_m[beside]
        c = machine.cart_offsets_m[link] - machine.cart_offsets_m[beside]
        turned = _turned(at.P, a)
        moved = turned.plus(-c[:, None])
        v[link] = v[beside] + moved
        dots = sum_of([v[beside][i] * moved[i] - turned[i].times(c[i]) for i in range(3)])
        squares.append(dots.times(2.0).plus(machine.lengths_m[beside] ** 2 + a @ a + c @ c))
    beyond = machine.cart_offsets_m[PRIMARY, 0]
    carts = (at.across[:, 0] - s).plus((beyond[2] - beyond[:2])[:, None])
    first, second = PRIMARY[:2].tolist()
    between = _turned(at.P, chart.joints_m[first] - chart.joints_m[second])[0] - s[0] + s[1]
    return Links(
        _loosened(joined([v[link] for link in range(_LINKS)]), 8.0 * _ROUNDED),
        _loosened(joined([_turned(at.P, joint) for joint in chart.joints_m]), 8.0 * _ROUNDED),
        _loosened(joined(squares[:2]), 16.0 * _ROUNDED),
        _loosened(joined([carts[0], carts[1], between.plus(beyond[1] - beyond[0])]), 8.0 * _ROUNDED),
        at.D - s * s,
    )


def _turned(P: Form, joint: FloatArray) -> Form:
    """Turn a vector (3,) of the frame into the world; (3, n)."""
    used = np.flatnonzero(joint).tolist() or [0]
    return joined([sum_of([P[i, j].times(joint[j]) for j in used]) for i in range(3)])


def _symbols(chart: Chart) -> dict[int, int]:
    return {k: symbol for symbol, k in enumerate(chart.free)}


def _middle_half(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    fixed = low == high
    half = np.where(fixed, 0.0, 0.5 * (high - low) * (1.0 + 1e-14) + 8.0 * _ROUNDED)
    return 0.5 * (low + high), half


def _loosened(form: Form, error: float) -> Form:
    """Allow for constants of the machine that are rounded."""
    return Form(form.c, form.g, form.q, form.e + error, form.size + error)
