"""Declared bodies as shapes of a MuJoCo model: meshes in the frames of carts, links, platform and world.

Frames of links have their x axis along the link; that of a rod is at its tip.
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.export.models.xml import Element, add
from pipeline.machine.bodies.meshes import BodyMesh, body_meshes
from pipeline.machine.geometry import TELESCOPES, Machine
from pipeline.machine.shapes.model import FrameKind

Shapes = tuple[BodyMesh, ...]
_SEEN_THROUGH = "0.6 0.6 0.6 0.3"


def add_meshes(root: Element, machine: Machine) -> Shapes:
    """Write the corners of all declared bodies, which are convex, as assets that `add_shapes` refers to."""
    meshes = body_meshes(machine)
    if meshes:
        asset = add(root, "asset")
        for mesh in meshes:
            add(asset, "mesh", name=_name(mesh), vertex=_vertices(machine, mesh))
    return meshes


def add_shapes(body: Element, meshes: Shapes, kind: FrameKind, number: int = 0, rod: bool = False) -> bool:
    """Give a body its shapes; of a telescope either those of its tube or of its rod.

    False if none is declared, or of a link only what is attached to it.
    """
    found = [mesh for mesh in meshes if (mesh.kind, mesh.number) == (kind, number)]
    if kind == FrameKind.LINK and number in TELESCOPES:
        found = [mesh for mesh in found if bool(mesh.shares.any()) == rod]
    for mesh in found:
        colour = {"rgba": _SEEN_THROUGH} if mesh.is_around else {}
        add(body, "geom", name=_name(mesh), type="mesh", mesh=_name(mesh), **colour)
    return any(mesh.is_link for mesh in found) if kind == FrameKind.LINK else bool(found)


def _vertices(machine: Machine, mesh: BodyMesh) -> FloatArray:
    """Return the corners in the frame of the model, (k, 3)."""
    if mesh.kind != FrameKind.LINK:
        return mesh.vertices_m
    k = TELESCOPES.tolist().index(mesh.number) if mesh.number in TELESCOPES else None
    length = float(machine.lengths_m[mesh.number] if k is None else machine.strokes_m[k, 1])
    corners = mesh.vertices_at(length)
    if k is not None and mesh.shares.any():
        corners = corners - [0.0, 0.0, length]
    return np.asarray(corners[:, [2, 0, 1]], dtype=float)


def _name(mesh: BodyMesh) -> str:
    return f"body_{mesh.name.replace(' ', '_')}"
