"""The bodies of a configuration as hulls, and which pairs of them are checked.

Pairs are derived from the machine. Not checked are two bodies of one frame, and links that share a joint. A link
touches what its joint sits on, by construction: where a body that does not move relative to a joint is near it, the
link is cut short there by `clearance.joint_trim_m`, and the rest of it checked. So are bodies at the ends of links;
what slides on one end of a telescope is kept apart from what is on the other.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import MachineConfig
from pipeline.config.machine.bodies import LINK_NAMES
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.hulls import body_hull, config_name, link_hulls
from pipeline.machine.shapes.model import Bodies, FrameKind, Neighbours, SweptHull

_TELESCOPES = ("l2b", "l3b")
_NEAR_M = 0.02
"""A body counts as touching a joint if it is nearer to it than this, or than the required distance."""


@dataclass(frozen=True, eq=False)
class _Joints:
    """Where the joints of the links are, and what a link loses at them.

    Attributes
    ----------
    arms : (6,)
        Arm 0 to 2 of each link.
    platform_m, cart_m : (6, 3)
        Joints in the platform frame, and from the point of the rail that the cart is at.
    rails_m : (3, 3)
        The rails, x zero.
    trim_m : (2,)
        What is cut off at the platform and at the cart.
    required_m : float
        Least distance of surfaces.
    shared_m : float
        How far apart the joints of two links may be that count as one: a calibration tells them apart.
    """

    arms: tuple[int, ...]
    platform_m: FloatArray
    cart_m: FloatArray
    rails_m: FloatArray
    trim_m: tuple[float, float]
    required_m: float
    shared_m: float


def build_bodies(config: MachineConfig) -> Bodies | None:
    """Build the bodies of a machine and the pairs whose distances do not depend on x; None if there are none.

    What is fixed in space and not endless along X is left to `obstacles.build_obstacles`.
    """
    if not config.bodies and config.link_bodies is None:
        return None
    joints = _joints(config)
    hulls = [hull for hull in (body_hull(config, body) for body in config.bodies) if not hull.is_obstacle]
    hulls += link_hulls(config)
    found = _Pairs(hulls, [], [], [])
    ignored = {frozenset(pair) for pair in config.clearance.ignore}
    for i, j in combinations(range(len(hulls)), 2):
        a, b = hulls[i], hulls[j]
        if config.link_bodies is None and a.is_link and b.is_link:
            continue
        if frozenset((config_name(a), config_name(b))) in ignored:
            found.leave_out(a, b, "machine.clearance.ignore", "not checked")
        elif why := _never_checked(joints, a, b):
            if why != _ONE_FRAME:
                found.leave_out(a, b, why, "not checked")
        else:
            found.add(joints, i, j)
    if not found.pairs:
        return None
    return Bodies(
        tuple(found.hulls), tuple(found.pairs), tuple(found.names), joints.required_m, tuple(found.neighbours)
    )


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Hulls, and the pairs found so far."""

    hulls: list[SweptHull]
    pairs: list[tuple[int, int]]
    names: list[str]
    neighbours: list[Neighbours]

    def leave_out(self, a: SweptHull, b: SweptHull, why: str, treatment: str) -> None:
        self.neighbours.append(Neighbours(f"{a.name} and {b.name}", why, treatment))

    def add(self, joints: _Joints, i: int, j: int) -> None:
        """Add a pair, its links cut short where they meet the other at a joint."""
        a, b = self.hulls[i], self.hulls[j]
        cuts = [_cut(joints, a, b), _cut(joints, b, a)]
        first, second = (self._trimmed(k, cut) for k, cut in zip((i, j), cuts, strict=True))
        left = first is not None and second is not None
        for at, cut in zip(("platform", "cart"), np.max(cuts, axis=0).tolist(), strict=True):
            if cut > 0.0:
                rest = f"checked beyond {cut:g} m from it" if left else "not checked"
                self.leave_out(a, b, f"a joint on the {at}", rest)
        if first is not None and second is not None:
            self.pairs.append((first, second))
            self.names.append(f"{a.name} and {b.name}")

    def _trimmed(self, number: int, cut: tuple[float, float]) -> int | None:
        """Find a link cut short at its platform and cart ends, or make it; None if nothing is left of it."""
        hull = self.hulls[number]
        if cut == (0.0, 0.0):
            return number
        points = hull.points_m.copy()
        if cut[1] > 0.0:
            points[0, 1] = max(points[0, 1], cut[1])
        if cut[0] > 0.0:
            points[1, 1] = min(points[1, 1], -cut[0])
        if points[0, 0] == points[1, 0] and points[0, 1] >= points[1, 1]:
            return None
        for known, other in enumerate(self.hulls):
            if other.name == hull.name and np.array_equal(other.points_m, points):
                return known
        self.hulls.append(replace(hull, points_m=points))
        return len(self.hulls) - 1


_ONE_FRAME = "one frame"


def _never_checked(joints: _Joints, a: SweptHull, b: SweptHull) -> str:
    """Say why two hulls are not checked; empty if they are."""
    fixed = a.kind == b.kind == FrameKind.FIXED
    if fixed or ((a.kind, a.number) == (b.kind, b.number) and not _slide(a, b)):
        return _ONE_FRAME
    kinds = {a.kind, b.kind}
    if kinds == {FrameKind.LINK} and a.number != b.number and _share_joint(joints, a, b):
        return "they share a joint"
    if kinds == {FrameKind.CART, FrameKind.FIXED}:
        cart, fixed_hull = (a, b) if a.kind == FrameKind.CART else (b, a)
        # A cart never moves towards what is endless along X: it is checked only to say that it is too close always.
        if fixed_hull.number == cart.number + 1:
            return "the cart slides on its rail"
        gap = _gap(cart.points_m + joints.rails_m[cart.number], fixed_hull, cart.radius_m)
        return "" if gap < joints.required_m else _ONE_FRAME
    return ""


def _slide(a: SweptHull, b: SweptHull) -> bool:
    """Tell whether two hulls of one link are on different ends of a telescope: its rod is on both."""
    ends = [set(hull.points_m[:, 0].tolist()) for hull in (a, b)]
    return (
        a.kind == FrameKind.LINK and LINK_NAMES[a.number] in _TELESCOPES and sorted(map(sorted, ends)) == [[0.0], [1.0]]
    )


def _share_joint(joints: _Joints, a: SweptHull, b: SweptHull) -> bool:
    """Tell whether two links share a joint that both hulls are at."""
    i, j = a.number, b.number
    on_cart, on_platform = (
        bool(np.linalg.norm(places[i] - places[j]) <= joints.shared_m) for places in (joints.cart_m, joints.platform_m)
    )
    on_cart = on_cart and joints.arms[i] == joints.arms[j]
    at_cart, at_platform = (all(_is_at(joints, hull, end) for hull in (a, b)) for end in (0.0, 1.0))
    return (on_cart and at_cart) or (on_platform and at_platform)


def _is_at(joints: _Joints, hull: SweptHull, end: float) -> bool:
    """Tell whether a hull of a link is near the joint at an end: links are at both."""
    share, along = hull.points_m.T
    near = np.abs(along).min() - hull.radius_m < max(joints.required_m, _NEAR_M)
    return hull.is_link or bool(share[0] == end and near)


def _cut(joints: _Joints, link: SweptHull, other: SweptHull) -> tuple[float, float]:
    """Return what a link loses at its platform and cart ends against another hull: nothing unless its joint is there.

    A tube ends before the platform joint, and loses nothing there.
    """
    if link.kind != FrameKind.LINK or other.kind == FrameKind.LINK:
        return 0.0, 0.0
    number = link.number
    arm = joints.arms[number]
    if other.kind == FrameKind.PLATFORM:
        near = link.points_m[1, 0] == 1.0 and _touches(joints, link, joints.platform_m[number], other)
        return joints.trim_m[0] if near else 0.0, 0.0
    if other.kind == FrameKind.CART and other.number != arm:
        return 0.0, 0.0
    if link.points_m[0, 0] != 0.0:
        return 0.0, 0.0
    joint = joints.cart_m[number] + (joints.rails_m[arm] if other.kind == FrameKind.FIXED else 0.0)
    return 0.0, joints.trim_m[1] if _touches(joints, link, joint, other) else 0.0


def _touches(joints: _Joints, link: SweptHull, joint: FloatArray, other: SweptHull) -> bool:
    """Tell whether a joint that does not move relative to a hull is near it, whatever the pose."""
    return _gap(joint[None], other, link.radius_m) < max(joints.required_m, _NEAR_M)


def _gap(points: FloatArray, hull: SweptHull, radius_m: float) -> float:
    """Distance of the surface of a hull from that of points (k, 3) in its frame."""
    points = points * [0.0, 1.0, 1.0] if hull.endless else points
    distance = hull_separation(points[..., None], hull.points_m[..., None]).distance_m
    return float(distance[0]) - radius_m - hull.radius_m


def _joints(config: MachineConfig) -> _Joints:
    links = [getattr(config.links, name) for name in LINK_NAMES]
    trim = config.clearance.joint_trim_m
    return _Joints(
        arms=tuple(int(name[1]) - 1 for name in LINK_NAMES),
        platform_m=np.array([link.platform_point_m for link in links]),
        cart_m=np.array([link.cart_offset_m for link in links]),
        rails_m=np.array([(0.0, rail.y_m, rail.z_m) for rail in config.rails]),
        trim_m=(trim.platform, trim.cart),
        required_m=config.clearance.bodies_m,
        shared_m=config.clearance.shared_joint_m,
    )
