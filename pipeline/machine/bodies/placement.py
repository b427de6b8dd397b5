"""Where hulls are at poses: their points move with the platform, a cart or a link."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.geometry import Machine, cart_joints, link_vectors, rotation
from pipeline.machine.rails import rail_points
from pipeline.machine.shapes.model import FrameKind, SweptHull


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames that hulls move with, at n poses, stored coordinate by coordinate.

    Attributes
    ----------
    tcp_m : (3, n)
        The TCP.
    carts_m : (3, 3, n)
        The carts on their rails.
    rotation : (3, 3, n)
        R of the platform.
    joints_m, vectors_m : (6, 3, n)
        Cart joints C of the links, and A - C.
    """

    tcp_m: FloatArray
    carts_m: FloatArray
    rotation: FloatArray
    joints_m: FloatArray
    vectors_m: FloatArray

    @classmethod
    def of(cls, machine: Machine, pose: FloatArray, carts_m: FloatArray) -> Self:
        """Place the frames at poses (n, 6) with carts (n, 3)."""
        R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
        return cls(
            tcp_m=pose[:, :3].T,
            carts_m=np.moveaxis(rail_points(machine, carts_m), 0, -1),
            rotation=np.moveaxis(R, 0, -1),
            joints_m=np.moveaxis(cart_joints(machine, carts_m), 0, -1),
            vectors_m=np.moveaxis(link_vectors(machine, pose, carts_m), 0, -1),
        )

    def __len__(self) -> int:
        return int(self.tcp_m.shape[1])

    @cached_property
    def _directions(self) -> FloatArray:
        """Unit vectors along the links, (6, 3, n)."""
        v = self.vectors_m
        length = np.sqrt(v[:, 0] ** 2 + v[:, 1] ** 2 + v[:, 2] ** 2)
        return np.asarray(v / np.where(length > 0.0, length, 1.0)[:, None], dtype=float)

    def take(self, rows: IntArray | BoolArray) -> Self:
        """Keep some of the poses."""
        parts = (self.tcp_m, self.carts_m, self.rotation, self.joints_m, self.vectors_m)
        return type(self)(*(part[..., rows] for part in parts))

    def points(self, hull: SweptHull) -> FloatArray:
        """Place the points of a hull, shape (k, 3, n)."""
        given = hull.points_m
        if hull.kind == FrameKind.PLATFORM:
            return np.asarray(np.einsum("ijn,kj->kin", self.rotation, given) + self.tcp_m, dtype=float)
        if hull.kind == FrameKind.LINK:
            joint, vector, along = (part[hull.number] for part in (self.joints_m, self.vectors_m, self._directions))
            return np.stack([joint + part * vector + metres * along for part, metres in given.tolist()])
        placed = np.empty((*given.shape, len(self)))
        placed[:] = given[..., None]
        if hull.kind == FrameKind.CART:
            placed += self.carts_m[hull.number]
        return placed
