"""A theorem: without tilt, det H = 0 lies between some working modes, whatever the path.

Let both parallelograms, 2a-2b and 3a-3b, have sides that are equal on platform and cart and lie along y, h_2 and h_3
wide, and let the platform only turn about y: R e_y = e_y. Then v_2b = v_2a and v_3b = v_3a, and subtracting columns
2a from 2b and 3a from 3b leaves two couples h_2 e_y x u_2 and h_3 e_y x u_3, which have no force and no moment about
y. H falls into two blocks, and with the characteristic length L

    det H = (h_2 h_3 / L^3) F D,    F = u_2x u_3z - u_2z u_3x,

where D is the determinant of the forces and the moments about y of links 1, 2a, 3a and 3c. (The factors of D for the
right-angled triangle are not needed.) u_2 and u_3 are directions of links of fixed length: F is continuous along every
motion. If its signs at the start and at the goal differ, it vanishes on the way, and with it det H.

Numbers of the configuration are taken as the decimals they are written as, and all of this is exact or in balls.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, fmpq

from pipeline.config import Config, MachineConfig, PoseConfig
from pipeline.config.choices import TiltAxis
from pipeline.config.machine.links import FixedLinkConfig, RailConfig
from pipeline.inclusion.condition import above, below
from pipeline.machine.geometry import MODE_SIGNS, Machine
from pipeline.machine.pose import RY
from pipeline.route.regions.endpoints import Endpoint

_RADIUS_RAD = 1e-9
"""How far ry is from the one computed in floats, at most; that a solution is this near is proven."""


@dataclass(frozen=True)
class Theorem:
    """Whether the theorem holds for a machine and a task, and what it says.

    Attributes
    ----------
    unmet : tuple of str
        What of its hypothesis does not hold; empty if all does.
    start, goal : (float, float) or None
        Bounds of F there; None where its hypothesis does not hold, or no ry was proven.
    """

    unmet: tuple[str, ...]
    start: tuple[float, float] | None = None
    goal: tuple[float, float] | None = None

    @property
    def no_path(self) -> bool:
        """Whether every path from start to goal meets det H = 0."""
        if self.unmet or self.start is None or self.goal is None:
            return False
        return self.start[0] > 0.0 > self.goal[1] or self.start[1] < 0.0 < self.goal[0]

    @property
    def sentence(self) -> str:
        """What is proven, or why nothing is."""
        if self.unmet:
            return f"the theorem does not apply: {'; '.join(self.unmet)}"
        if self.start is None or self.goal is None:
            return "the theorem applies, but the sign of F at an end is not certain"
        where = f"F is {_shown(self.start)} at the start and {_shown(self.goal)} at the goal"
        if self.no_path:
            return (
                f"no path exists: {where}, it is continuous along every motion without tilt, and a factor of det H "
                "(theorem). Every path meets a Type-II singularity, whatever the grid, limits or cap on kappa"
            )
        return f"the theorem proves nothing here: {where}, without a change of sign"


def apply_theorem(config: Config, machine: Machine, ends: tuple[Endpoint, Endpoint]) -> Theorem:
    """Check the hypothesis against the configuration and bound F at both ends."""
    unmet = tuple(_unmet(config))
    if unmet:
        return Theorem(unmet)
    poses = (config.task.start, config.task.goal)
    start, goal = (_bounds_of_f(config.machine, machine, pose, end) for pose, end in zip(poses, ends, strict=True))
    return Theorem((), start, goal)


def decimal(value: float) -> Fraction:
    """Take a number of the configuration as the decimal it is written as: the shortest that gives this float."""
    return Fraction(repr(float(value)))


def parallelogram_widths(config: MachineConfig) -> tuple[Fraction, Fraction] | None:
    """Widths h_2 and h_3 of the parallelograms in metres; None unless both are as the theorem asks for."""
    links = config.links
    widths = []
    for first, second in ((links.l2a, links.l2b), (links.l3a, links.l3b)):
        platform = _difference(second.platform_point_m, first.platform_point_m)
        cart = _difference(second.cart_offset_m, first.cart_offset_m)
        if platform != cart or platform[0] or platform[2] or not platform[1]:
            return None
        widths.append(platform[1])
    return widths[0], widths[1]


def _unmet(config: Config) -> Iterator[str]:
    locked = set(config.task.locked_axes)
    if config.task.tilt_max_deg > 0.0 and locked != set(TiltAxis):
        free = [axis.value for axis in TiltAxis if axis not in locked]
        yield (
            f"the machine may tilt ({', '.join(free)} up to task.tilt_max_deg {config.task.tilt_max_deg:g}); "
            "it is for machines without tilt (task.locked_axes: [rx, rz])"
        )
    if any(any(rail.slopes) for rail in config.machine.rails):
        yield "rails are not parallel to X (machine.rails.slopes), as F is bounded for"
    if parallelogram_widths(config.machine) is None:
        yield "links 2a-2b and 3a-3b are not parallelograms with equal sides along y on platform and cart"


def _bounds_of_f(
    config: MachineConfig, machine: Machine, pose: PoseConfig, end: Endpoint
) -> tuple[float, float] | None:
    """Bound F at a pose without tilt; None if no solution ry of the triangle is proven near the one in floats.

    A solution is proven by opposite signs of the mismatch on both sides, where link 3a reaches its rail throughout.
    """
    signs, links = MODE_SIGNS[end.mode], config.links
    ry = arb(float(end.pose[RY]))
    around = ry + arb(0, _RADIUS_RAD)

    def third(angle: arb) -> list[arb]:
        return _vector(config.rails[2], links.l3a, pose, signs[2], angle)

    low, high = (_mismatch(config, third(angle), angle) for angle in (ry - arb(_RADIUS_RAD), ry + arb(_RADIUS_RAD)))
    v3 = third(around)
    if not ((low < 0 < high or high < 0 < low) and v3[0].is_finite()):
        return None
    if not _orientation(config, v3, around) * machine.triangle_sign > 0:
        return None
    v2 = _vector(config.rails[1], links.l2a, pose, signs[1], around)
    F = (v2[0] * v3[2] - v2[2] * v3[0]) / (_ball(links.l2a.length_m) * _ball(links.l3a.length_m))
    return (below(F), above(F)) if F.is_finite() else None


def _vector(rail: RailConfig, link: FixedLinkConfig, pose: PoseConfig, sign: float, ry: arb) -> list[arb]:
    """Compute v = A - C of a primary link without tilt: y and z from the pose, x = -/+ sqrt(D) by its mode."""
    turned = _turned(link.platform_point_m, ry)
    y = _ball(pose.y_m) + turned[1] - _ball(rail.y_m) - _ball(link.cart_offset_m[1])
    z = _ball(pose.z_m) + turned[2] - _ball(rail.z_m) - _ball(link.cart_offset_m[2])
    return [-int(sign) * (_ball(link.length_m) ** 2 - y * y - z * z).sqrt(), y, z]


def _mismatch(config: MachineConfig, g: Sequence[arb], ry: arb) -> arb:
    """Half of what |A_3c - C_3c|^2 exceeds len_3c^2 by, as in `pipeline.machine.triangle`."""
    first, third = config.links.l3a, config.links.l3c
    w = _difference(third.platform_point_m, first.platform_point_m)
    d = _difference(third.cart_offset_m, first.cart_offset_m)
    excess = Fraction(0)
    if third.length_m is not None:
        excess = decimal(third.length_m) ** 2 - decimal(first.length_m) ** 2 - sum(x * x for x in w)
    result = -_ball((excess - sum(x * x for x in d)) / 2)
    for v, x, t in zip(g, d, _turned(w, ry), strict=True):
        result += (v - _ball(x)) * t - v * _ball(x)
    return result


def _orientation(config: MachineConfig, g: Sequence[arb], ry: arb) -> arb:
    """Compute e_y . (R w x (g - d)), whose sign is the triangle's assembly branch."""
    first, third = config.links.l3a, config.links.l3c
    w = _turned(_difference(third.platform_point_m, first.platform_point_m), ry)
    d = _difference(third.cart_offset_m, first.cart_offset_m)
    return w[2] * (g[0] - _ball(d[0])) - w[0] * (g[2] - _ball(d[2]))


def _turned(vector: Sequence[float | Fraction], ry: arb) -> list[arb]:
    x, y, z = (_ball(value) for value in vector)
    c, s = ry.cos(), ry.sin()
    return [c * x + s * z, y, c * z - s * x]


def _ball(value: float | Fraction) -> arb:
    exact = value if isinstance(value, Fraction) else decimal(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def _difference(a: Sequence[float], b: Sequence[float]) -> list[Fraction]:
    return [decimal(x) - decimal(y) for x, y in zip(a, b, strict=True)]


def _shown(bounds: tuple[float, float]) -> str:
    return f"{(bounds[0] + bounds[1]) / 2.0:.5f}"
