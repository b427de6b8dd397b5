"""The bodies of the machine in the 3-D scene: a node each, that moves with its frame."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.arrays import FloatArray, IntArray
from pipeline.figures import style
from pipeline.machine.bodies.meshes import BodyMesh, body_meshes, mesh_frame
from pipeline.machine.drawing import DrawnPoints
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.shapes.model import Bodies, FrameKind
from pipeline.show.rods import PLATFORM, rgb, rod_shade, tube_shade

if TYPE_CHECKING:
    from viser import SceneApi

_FLOOR, _SEEN_THROUGH = "#C8C8C8", 0.5


@dataclass(frozen=True, eq=False)
class BodyNode:
    """A body and its node in the scene."""

    mesh: BodyMesh
    node: Any


def draw_bodies(scene: "SceneApi", machine: Machine, obstacles: Bodies | None) -> list[BodyNode]:
    """Add a node for every body, obstacles of the task as well; those that move are placed by `move_bodies`."""
    nodes = []
    for mesh in body_meshes(machine, obstacles):
        colour, opacity = (_FLOOR, _SEEN_THROUGH) if mesh.is_around else (style.GREY, None)
        node = scene.add_mesh_simple(
            f"/bodies/{mesh.name.replace(' ', '-')}", mesh.vertices_m, mesh.faces,
            color=_colour(rgb(colour)), opacity=opacity, flat_shading=True, side="double", cast_shadow=False,
        )  # fmt: skip
        nodes.append(BodyNode(mesh, node))
    return nodes


def move_bodies(nodes: list[BodyNode], pose: FloatArray, points: DrawnPoints, colours: IntArray, alarmed: bool) -> None:
    """Move bodies to a pose (6,) and the points drawn there, in the colours (3, 3) of the arms."""
    for body in nodes:
        mesh, node = body.mesh, body.node
        if mesh.kind == FrameKind.FIXED:
            continue
        frame = mesh_frame(mesh, pose, points)
        node.wxyz, node.position = Rotation.from_matrix(frame.axes).as_quat(scalar_first=True), frame.origin_m
        if mesh.shares.any():
            node.vertices = mesh.vertices_at(frame.length_m).astype(np.float32)
        node.color = _colour(_moving_colour(mesh, colours, alarmed))


def _moving_colour(mesh: BodyMesh, colours: IntArray, alarmed: bool) -> IntArray:
    if mesh.kind == FrameKind.PLATFORM:
        return rgb(style.VERMILLION if alarmed else PLATFORM)
    if mesh.kind == FrameKind.CART:
        return np.asarray(colours[mesh.number])
    arm: IntArray = colours[ARM_OF_LINK[mesh.number]]
    if mesh.number not in TELESCOPES:
        return arm
    return rod_shade(arm) if mesh.shares.any() else tube_shade(arm)


def _colour(colour: IntArray) -> tuple[int, int, int]:
    red, green, blue = colour.tolist()
    return red, green, blue
