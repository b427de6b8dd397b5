"""Triangles of the bodies of a machine, each in its own frame: what reports, figures and `show` draw.

All that is within a radius of a hull is drawn as the hull of small polyhedra around its points: a capsule has twelve
sides. What is endless ends a little beyond the machine; links without a radius are axes, and have no triangles.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
from scipy.spatial import ConvexHull

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.drawing import DrawnPoints, rail_ends
from pipeline.machine.geometry import Machine, cart_joints, rotation
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_SIDES = 12
_FEW_POINTS = 8
"""Hulls of more points than this have smaller polyhedra around them."""
_THINNEST_M = 0.0005
"""Radius that sheets and lines without one are drawn with."""
_LONG_M = 10.0
"""Length of a link for which its triangles are found."""
_BEYOND_M = np.array([0.15, 0.2, 0.2])
"""How far beyond the rails endless bodies are drawn, and what is farther away than that, how deep."""
_DEEP_M = 0.05


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """A closed surface of triangles, corners in the order that makes normals point outwards.

    Attributes
    ----------
    name, kind, number, endless
        The body, and the frame it moves with, as of its `SweptHull`.
    vertices_m : (k, 3)
        Corners in that frame; for a link along z, from the cart joint.
    shares : (k,)
        The part of the link's length to be added to z; zero for all others.
    faces : (m, 3)
        Triangles between corners.
    is_link : bool
        Whether it is a link, or the rod or tube of one, and not a body attached to it.
    """

    name: str
    kind: FrameKind
    number: int
    endless: bool
    vertices_m: FloatArray
    shares: FloatArray
    faces: IntArray
    is_link: bool = False

    @property
    def is_around(self) -> bool:
        """Whether it is a floor or wall, endless along X, which other bodies are seen before."""
        return self.endless and self.number == 0

    def vertices_at(self, length_m: float) -> FloatArray:
        """Return the corners for a length of the link, in the frame, shape (k, 3)."""
        return np.asarray(self.vertices_m + np.outer(self.shares, [0.0, 0.0, length_m]), dtype=float)


@dataclass(frozen=True, eq=False)
class MeshFrame:
    """Where the frame of a mesh is: its axes as columns (3, 3), its origin (3,), and the length of its link."""

    axes: FloatArray
    origin_m: FloatArray
    length_m: float = 0.0

    def place(self, mesh: BodyMesh) -> FloatArray:
        """Return the corners of a mesh in space, shape (k, 3)."""
        return np.asarray(self.origin_m + mesh.vertices_at(self.length_m) @ self.axes.T, dtype=float)


def body_hulls(machine: Machine, obstacles: Bodies | None = None) -> tuple[SweptHull, ...]:
    """Return the hulls that have a surface, once each and links whole; none for a machine without bodies.

    `obstacles` are those of a task, instead of those of the machine's frame alone.
    """
    # Links that are cut short come after the whole ones.
    named: dict[str, SweptHull] = {}
    for bodies in (machine.bodies, obstacles or machine.obstacles):
        for hull in () if bodies is None else bodies.hulls:
            named.setdefault(hull.name, hull)
    return tuple(hull for hull in named.values() if hull.radius_m > 0.0 or _has_surface(hull))


def _has_surface(hull: SweptHull) -> bool:
    """Tell whether a hull without a radius is more than an axis or a point."""
    return hull.kind != FrameKind.LINK and len(hull.points_m) > 1


def body_meshes(machine: Machine, obstacles: Bodies | None = None, pieces: int = 1) -> tuple[BodyMesh, ...]:
    """Build the surfaces of `body_hulls`, what is long in so many pieces: drawings sort them by depth."""
    hulls = _seen(body_hulls(machine, obstacles))
    window = _window(machine, hulls)
    ended = (_ended(hull, window) if hull.endless else hull for hull in hulls)
    return tuple(build_mesh(piece) for hull in ended for piece in _pieces(hull, pieces))


def build_mesh(hull: SweptHull) -> BodyMesh:
    """Build the surface of a hull; of an endless one the points given are both its ends."""
    points, shares = hull.points_m, np.zeros(len(hull.points_m))
    if hull.kind == FrameKind.LINK:
        # Which corners there are does not depend on the length.
        shares = points[:, 0]
        points = np.column_stack([np.zeros((len(points), 2)), points @ [_LONG_M, 1.0]])
    around = max(hull.radius_m, _THINNEST_M) * _directions(points)
    corners = (points[:, None] + around).reshape(-1, 3)
    found = ConvexHull(corners)
    used = found.vertices
    a, b, c = corners[found.simplices].transpose(1, 0, 2)
    inwards = (np.cross(b - a, c - a) * found.equations[:, :3]).sum(axis=1) < 0.0
    faces = np.where(inwards[:, None], found.simplices[:, ::-1], found.simplices)
    lengthwise = np.repeat(shares, len(around))[used]
    vertices = corners[used] - lengthwise[:, None] * [0.0, 0.0, _LONG_M]
    faces = np.searchsorted(used, faces)
    return BodyMesh(hull.name, hull.kind, hull.number, hull.endless, vertices, lengthwise, faces, hull.is_link)


def mesh_frame(mesh: BodyMesh, pose: FloatArray, points: DrawnPoints) -> MeshFrame:
    """Find the frame that a mesh moves with, for a pose (6,) and the points drawn there."""
    if mesh.kind == FrameKind.PLATFORM:
        return MeshFrame(rotation(*pose[3:]), pose[:3])
    if mesh.kind == FrameKind.CART:
        return MeshFrame(np.eye(3), points.feet_m[mesh.number])
    if mesh.kind == FrameKind.LINK:
        joint = points.cart_joints_m[mesh.number]
        vector = points.platform_joints_m[mesh.number] - joint
        length = float(np.linalg.norm(vector))
        return MeshFrame(_axes_along(vector / length), joint, length)
    return MeshFrame(np.eye(3), np.zeros(3))


def _axes_along(z: FloatArray) -> FloatArray:
    """Return a right-handed frame whose z is a unit vector; x is across the axis that z has least of."""
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _directions(points: FloatArray) -> FloatArray:
    """Return unit vectors all around, their poles along a segment, (n, 3)."""
    if len(points) > _FEW_POINTS:
        ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
        few = ways[np.abs(ways).sum(axis=1) != 2.0]
        return np.asarray(few / np.linalg.norm(few, axis=1, keepdims=True), dtype=float)
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    half = np.sqrt(0.5)
    rings = [
        np.column_stack([size * ring, np.full(_SIDES, z)]) for size, z in ((1.0, 0.0), (half, half), (half, -half))
    ]
    ball = np.vstack([*rings, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    if len(points) != 2 or np.array_equal(*points):
        return ball
    along = points[1] - points[0]
    return np.asarray(ball @ _axes_along(along / np.linalg.norm(along)).T, dtype=float)


def _window(machine: Machine, hulls: tuple[SweptHull, ...]) -> FloatArray:
    """Return least and largest coordinates to which endless bodies are drawn, so that some of each is, (2, 3)."""
    joints = [cart_joints(machine, end) for end in machine.travel_m.T]
    ends = np.vstack([rail_ends(machine).reshape(-1, 3), *joints])
    low, high = ends.min(axis=0) - _BEYOND_M, ends.max(axis=0) + _BEYOND_M
    for hull in hulls:
        if hull.endless:
            low[1:] = np.minimum(low[1:], hull.points_m[:, 1:].max(axis=0) - _DEEP_M)
            high[1:] = np.maximum(high[1:], hull.points_m[:, 1:].min(axis=0) + _DEEP_M)
    return np.stack([low, high])


def _ended(hull: SweptHull, window: FloatArray) -> SweptHull:
    """Cut an endless hull to a window (2, 3)."""
    profile = hull.points_m
    for axis in (1, 2):
        for end, sign in zip(window[:, axis], (1.0, -1.0), strict=True):
            profile = _cut(profile, sign * (profile[:, axis] - end))
    # Nothing is left of a slanting wall that passes the window's corner.
    profile = profile if len(profile) else hull.points_m
    ends = [profile * [0.0, 1.0, 1.0] + [x, 0.0, 0.0] for x in window[:, 0]]
    return replace(hull, points_m=np.vstack(ends))


def _seen(hulls: tuple[SweptHull, ...]) -> tuple[SweptHull, ...]:
    """Leave out the part of a rod that is within a tube."""
    tubes = {hull.number: hull.points_m[1] for hull in hulls if hull.is_link and hull.points_m[1, 0] == 0.0}
    return tuple(
        replace(hull, points_m=np.stack([tubes[hull.number], hull.points_m[1]]))
        if hull.is_link and hull.number in tubes and hull.points_m[1, 0] == 1.0
        else hull
        for hull in hulls
    )


def _pieces(hull: SweptHull, count: int) -> Iterator[SweptHull]:
    """Cut a hull between its first half of points and its second into pieces: capsules, links, and ended bodies."""
    if not hull.endless and len(hull.points_m) != 2:
        yield hull
        return
    first, second = np.split(hull.points_m, 2)
    for begin, end in pairwise(np.linspace(0.0, 1.0, count + 1)):
        ends = [first + share * (second - first) for share in (begin, end)]
        yield replace(hull, points_m=np.vstack(ends))


def _cut(points: FloatArray, inside: FloatArray) -> FloatArray:
    """Keep the part of a hull of points (k, 3) where a linear function, given at the points, is not negative."""
    kept, lost = points[inside >= 0.0], points[inside < 0.0]
    share = inside[inside >= 0.0][:, None] / np.subtract.outer(inside[inside >= 0.0], inside[inside < 0.0])
    crossings = kept[:, None] + share[..., None] * (lost - kept[:, None])
    return np.vstack([kept, crossings.reshape(-1, 3)])
