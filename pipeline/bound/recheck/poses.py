"""The machine at the poses of a box: arms, link vectors, carts, and H, as Taylor polynomials.

Poses are p = C_3a + L_3 Q (cos(beta) cos(alpha), sin(beta), cos(beta) sin(alpha)) - R a_3a with R = Q Ry(psi - alpha),
Q = Rx Rz: everything else is the definition of the machine, A_l = p + R a_l and C_l on its cart.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.bound.recheck.taylor import Taylor, coordinate, cosine_sine, inverse_root, known, stack
from pipeline.machine.geometry import ARM_OF_LINK, PRIMARY, TELESCOPES, TRIANGLE, Machine

_S = (4, 5)
_LINKS = len(ARM_OF_LINK)


@dataclass(frozen=True, eq=False)
class Posed:
    """Arms R a_l (6, 3, n), link 3a (3, n), A_1 and A_2a from C_3a (2, 3, n), D_k (2, n); symbols of coordinates."""

    symbols: dict[int, int]
    arms: Taylor
    third: Taylor
    joints: Taylor
    D: Taylor

    def at(self, boxes: IntArray) -> "Posed":
        """Select boxes (m,)."""
        return Posed(self.symbols, *(part.at(boxes) for part in (self.arms, self.third, self.joints, self.D)))


def pose(machine: Machine, middle: FloatArray, half: FloatArray) -> Posed:
    """Place the platform for boxes of middles and half widths (6, n), whatever s_1 and s_2."""
    symbols = {int(k): symbol for symbol, k in enumerate(np.flatnonzero((half > 0.0).any(axis=1)))}
    N, n = len(symbols), half.shape[1]
    (ca, sa), (cb, sb), (cx, sx), (cz, sz) = (cosine_sine(symbols.get(k), middle[k], half[k], N) for k in range(4))
    zero = known(np.zeros(n), N)
    first = stack([cz, cx * sz, sx * sz])
    second = stack([sz.scaled(-1.0), cx * cz, sx * cz])
    third = stack([zero, sx.scaled(-1.0), cx])
    w = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[PRIMARY[2]]
    long = np.hypot(w[0], w[2])
    cp, sp = (float(machine.triangle_sign * x / long) for x in (w[2], -w[0]))
    cy, sy = ca.scaled(cp) + sa.scaled(sp), ca.scaled(sp) - sa.scaled(cp)
    along, across = stack([first, third]), second
    R = stack(
        [
            along[0] * cy.expanded() - along[1] * sy.expanded(),
            across,
            along[0] * sy.expanded() + along[1] * cy.expanded(),
        ]
    )
    arms = R.mapped(machine.platform_points_m)
    link = along[0] * (cb * ca).expanded() + across * sb.expanded() + along[1] * (cb * sa).expanded()
    link = link.scaled(float(machine.lengths_m[PRIMARY[2]]))
    joints = stack([link + arms[k] - arms[PRIMARY[2]] for k in PRIMARY[:2].tolist()])
    reach = joints.shifted(-_bases(machine)[PRIMARY[:2], :, None] * [[0.0], [1.0], [1.0]])
    squares = np.repeat(machine.lengths_m[PRIMARY[:2], None] ** 2, n, axis=1)
    D = known(squares, N) - reach[:, 1] * reach[:, 1] - reach[:, 2] * reach[:, 2]
    return Posed(symbols, arms, link, joints, D)


@dataclass(frozen=True, eq=False)
class Assembled:
    """Vectors (6, 3, n), squared telescopes (2, n), carts 1 and 2 from cart 3 (2, n), and D_k - s_k^2 (2, n)."""

    vectors: Taylor
    squares: Taylor
    carts: Taylor
    ties: Taylor


def assemble(machine: Machine, at: Posed, middle: FloatArray, half: FloatArray) -> Assembled:
    """Place the carts of boxes of s_1 and s_2: A_k - C_k = (s_k, ...), and that of arm 3 is where it is.

    Telescopes are beside a link v of known length: |v + d|^2 = |v|^2 + 2 v . d + d^2, d = R a - c, d^2 = a^2 + c^2
    - 2 c . R a.
    """
    N, bases = len(at.symbols), _bases(machine)
    s = stack([coordinate(at.symbols.get(k), middle[k], half[k], N) for k in _S])
    reach = at.joints.shifted(-bases[PRIMARY[:2], :, None] * [[0.0], [1.0], [1.0]])
    vectors: dict[int, Taylor] = {int(PRIMARY[2]): at.third}
    for k, link in enumerate(PRIMARY[:2].tolist()):
        vectors[link] = stack([s[k], reach[k, 1], reach[k, 2]])
    squares = []
    for link in (*TELESCOPES.tolist(), TRIANGLE):
        beside = int(PRIMARY[ARM_OF_LINK[link]])
        a = machine.platform_points_m[link] - machine.platform_points_m[beside]
        c = machine.cart_offsets_m[link] - machine.cart_offsets_m[beside]
        turned = at.arms[link] - at.arms[beside]
        d = turned.shifted(-c[:, None])
        vectors[link] = vectors[beside] + d
        twice = vectors[beside] * d - turned.scaled(c[:, None])
        known_part = machine.lengths_m[beside] ** 2 + a @ a + c @ c
        squares.append((twice[0] + twice[1] + twice[2]).scaled(2.0).shifted(known_part))
    carts = stack([at.joints[k, 0] - s[k] for k in range(2)]).shifted(-bases[PRIMARY[:2], 0, None])
    v = stack([vectors[link] for link in range(_LINKS)])
    return Assembled(v, stack(squares[:2]), carts, at.D - s * s)


def statics(machine: Machine, at: Posed, found: Assembled) -> Taylor:
    """Compute the columns [u_l ; A'_l x u_l / L] of H, (6 rows, 6 links, n)."""
    n = found.squares.value.shape[-1]
    lengths = machine.lengths_m.copy()
    side = machine.platform_points_m[TRIANGLE] - machine.platform_points_m[PRIMARY[2]]
    lengths[TRIANGLE] = np.hypot(lengths[PRIMARY[2]], np.linalg.norm(side))
    inverse = [known(np.full(n, 1.0 / length), len(at.symbols)) for length in lengths]
    for k, link in enumerate(TELESCOPES.tolist()):
        shortest, longest = machine.strokes_m[k] ** 2
        inverse[link] = inverse_root(found.squares[k], shortest * (1.0 - 1e-12), longest * (1.0 + 1e-12))
    u = found.vectors * stack(inverse).expanded()
    a = at.arms
    moments = [a[:, i] * u[:, j] - a[:, j] * u[:, i] for i, j in ((1, 2), (2, 0), (0, 1))]
    unit = 1.0 / machine.characteristic_length_m
    return stack([*(u[:, i] for i in range(3)), *(moment.scaled(unit) for moment in moments)])


def _bases(machine: Machine) -> FloatArray:
    """Place C_l from C_3a (6, 3), along the rails from the origin of their carts."""
    rails = np.column_stack([np.zeros(len(machine.rails_m)), machine.rails_m])
    places = machine.cart_offsets_m + rails[ARM_OF_LINK]
    return np.asarray(places - places[PRIMARY[2]])
