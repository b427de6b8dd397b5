"""Distances of bodies by another library, coal: from their shapes alone, placed by other code than the pipeline's."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray
from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_ARMS = [0, 1, 1, 2, 2, 2]
_ENDLESS_M = 10.0
"""What is endless along X is so long on either side: machines are a few metres long."""
_FLAT_M = 1e-9
"""Hulls flatter than this have no volume."""
_ROUNDING_M = 1e-9


@dataclass(frozen=True, eq=False)
class _Part:
    """A shape of coal, and where it is in the frame of its body."""

    shape: Any
    rotation: FloatArray
    origin: FloatArray


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where a frame is at n poses: rotation (n, 3, 3), None for none, and origin (n, 3)."""

    rotation: FloatArray | None
    origin: FloatArray


class CoalOracle:
    """Distances between the surfaces of the pairs of `bodies` at n poses; below zero where they overlap.

    Raises
    ------
    ImportError
        If coal is not installed.
    """

    def __init__(self, bodies: Bodies, samples: PoseSamples) -> None:
        import coal

        self._coal, self.bodies = coal, bodies
        self._request, self._result = coal.DistanceRequest(), coal.DistanceResult()
        self._request.gjk_tolerance, self._request.gjk_max_iterations = 1e-12, 1_000
        machine, pose = samples.machine, samples.pose
        R = Rotation.from_euler("XZY", pose[:, [3, 5, 4]]).as_matrix()
        carts = [_cart_origin(machine, number, samples.carts_m[:, number]) for number in range(3)]
        self._frames = {
            (FrameKind.PLATFORM, 0): _Frame(R, pose[:, :3]),
            **{(FrameKind.CART, number): _Frame(None, origin) for number, origin in enumerate(carts)},
        }
        self._links = [
            (carts[arm] + machine.cart_offsets_m[k], pose[:, :3] + R @ machine.platform_points_m[k])
            for k, arm in enumerate(_ARMS)
        ]
        self._parts = [self._part(hull) for hull in bodies.hulls]
        self._still = np.zeros((len(pose), 3))
        self.asked = 0

    def distance(self, pair: int, row: int) -> float:
        """Measure a pair at one pose."""
        self.asked += 1
        first, second = (self._placed(number, row) for number in self.bodies.pairs[pair])
        self._result.clear()
        found = self._coal.distance(*first, *second, self._request, self._result)
        return float(found) - sum(self._beside(number) for number in self.bodies.pairs[pair])

    def least(self, pair: int, level_m: float) -> float:
        """Find the least distance of a pair among poses that may be nearer than a level; none is nearer than both.

        Two hulls whose points move by a and b at most between two poses come nearer by a + b at most on the way: poses
        between two of known distances are not asked for where these and the movement keep the hulls apart.
        """
        moved = sum(self._moved[number] for number in self.bodies.pairs[pair])
        last = len(self._still) - 1
        known = {row: self.distance(pair, row) for row in (0, last)}
        parts = [(0, last)]
        while parts:
            first, second = parts.pop()
            nearest = 0.5 * (known[first] + known[second] - (moved[second] - moved[first]))
            if second - first < 2 or nearest > level_m + _ROUNDING_M:
                continue
            middle = (first + second) // 2
            known[middle] = self.distance(pair, middle)
            parts += [(first, middle), (middle, second)]
        return min(known.values())

    @cached_property
    def _moved(self) -> list[FloatArray]:
        """How far the points of each hull have moved by each pose at most, shape (n,) each."""
        found = []
        for hull in self.bodies.hulls:
            steps = [np.linalg.norm(np.diff(point, axis=0), axis=1) for point in self._points(hull)]
            found.append(np.concatenate([[0.0], np.cumsum(np.max(steps, axis=0))]))
        return found

    def _points(self, hull: SweptHull) -> list[FloatArray]:
        """Place the points of a hull at all poses, (n, 3) each."""
        if hull.kind == FrameKind.LINK:
            return list(self._link_ends(hull, slice(None)))
        if hull.kind == FrameKind.FIXED:
            return [self._still]
        frame = self._frames[hull.kind, hull.number]
        return [frame.origin + (point if frame.rotation is None else frame.rotation @ point) for point in hull.points_m]

    def _link_ends(self, hull: SweptHull, rows: slice) -> tuple[FloatArray, FloatArray]:
        joint, end = (points[rows] for points in self._links[hull.number])
        vector = end - joint
        along = vector / np.linalg.norm(vector, axis=1)[:, None]
        first, second = (joint + part * vector + metres * along for part, metres in hull.points_m.tolist())
        return first, second

    def _beside(self, number: int) -> float:
        """Give what is to be taken off for a hull that coal knows without its radius."""
        return 0.0 if self._is_round(self.bodies.hulls[number]) else self.bodies.hulls[number].radius_m

    @staticmethod
    def _is_round(hull: SweptHull) -> bool:
        return len(hull.points_m) <= 2 and not hull.endless

    def _part(self, hull: SweptHull) -> _Part:
        """Make the shape of a hull: capsules and spheres with their radius, others without."""
        coal, still = self._coal, (np.eye(3), np.zeros(3))
        if hull.kind == FrameKind.LINK:
            return _Part(coal.Capsule(hull.radius_m, 1.0), *still)
        points = hull.points_m
        if self._is_round(hull):
            length = float(np.linalg.norm(points[-1] - points[0]))
            shape = coal.Capsule(hull.radius_m, length) if length else coal.Sphere(hull.radius_m)
            return _Part(shape, _turn_to(points[-1] - points[0]), points.mean(axis=0))
        if hull.endless:
            points = np.concatenate([points + [side * _ENDLESS_M, 0.0, 0.0] for side in (-1.0, 1.0)])
        spread = np.linalg.svd(points - points.mean(axis=0))
        vector = coal.StdVec_Vec3s()
        if spread.S[2] > _FLAT_M:
            vector.extend(points)
            return _Part(coal.ConvexBase.convexHull(vector, False, ""), *still)
        # A flat hull is a fan of triangles.
        corners, triangles = points[ConvexHull(points @ spread.Vh[:2].T).vertices], coal.StdVec_Triangle()
        vector.extend(corners)
        triangles.extend([coal.Triangle(0, k, k + 1) for k in range(1, len(corners) - 1)])
        return _Part(coal.Convex(vector, triangles), *still)

    def _placed(self, number: int, row: int) -> tuple[Any, Any]:
        """Place the shape of a hull at a pose."""
        hull, part = self.bodies.hulls[number], self._parts[number]
        if hull.kind == FrameKind.LINK:
            first, second = (end[0] for end in self._link_ends(hull, slice(row, row + 1)))
            part.shape.halfLength = 0.5 * float(np.linalg.norm(second - first))
            return part.shape, self._coal.Transform3s(_turn_to(second - first), 0.5 * (first + second))
        turn, origin = np.eye(3), np.zeros(3)
        if hull.kind != FrameKind.FIXED:
            frame = self._frames[hull.kind, hull.number]
            turn, origin = np.eye(3) if frame.rotation is None else frame.rotation[row], frame.origin[row]
        return part.shape, self._coal.Transform3s(turn @ part.rotation, origin + turn @ part.origin)


def _cart_origin(machine: Machine, number: int, cart_m: FloatArray) -> FloatArray:
    y, z = machine.rails_m[number]
    return np.column_stack([cart_m, np.full(len(cart_m), y), np.full(len(cart_m), z)])


def _turn_to(vector: FloatArray) -> FloatArray:
    """Make a rotation whose third column is along a vector: any of them, since capsules are round."""
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        return np.eye(3)
    z = vector / length
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
