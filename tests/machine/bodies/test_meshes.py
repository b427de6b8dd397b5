"""Surfaces of bodies: closed, of the declared size, and where the bodies are."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.meshes import BodyMesh, body_hulls, body_meshes, build_mesh, mesh_frame
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.drawing import drawn_points
from pipeline.machine.shapes.gjk import hull_separation
from pipeline.machine.shapes.model import FrameKind, SweptHull

SHAPES = {
    "sphere": (np.zeros((1, 3)), 0.1, 4.0 / 3.0 * np.pi * 0.001),
    "capsule": (np.array([[0.0, 0.0, 0.0], [0.3, 0.4, 0.0]]), 0.1, np.pi * 0.01 * (0.5 + 0.4 / 3.0)),
    "plate": (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), 0.0, 0.001),
    "box": (np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T.astype(float), 0.0, 1.0),
    "many": (np.vstack([np.eye(3), -np.eye(3), 0.5 * np.ones((4, 3)) + 0.01 * np.eye(4, 3)]), 0.0, None),
}


def volume(mesh: BodyMesh, length_m: float = 1.0) -> float:
    """Compute the volume within a surface, positive if its triangles face outwards."""
    a, b, c = mesh.vertices_at(length_m)[mesh.faces].transpose(1, 0, 2)
    return float((np.cross(a, b) * c).sum() / 6.0)


@pytest.mark.parametrize("shape", SHAPES)
def test_surfaces_are_closed_and_of_the_declared_size(shape: str) -> None:
    """Every edge is that of two triangles, in opposite directions; volumes are a little less than of round bodies."""
    points, radius, expected = SHAPES[shape]
    mesh = build_mesh(SweptHull("one", FrameKind.PLATFORM, 0, points, radius))
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()
    assert len({tuple(edge) for edge in edges}) == len(edges)
    assert {tuple(edge) for edge in edges} == {tuple(edge[::-1]) for edge in edges}
    assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices_m)))
    if expected is not None:
        assert 0.8 * expected < volume(mesh) < 1.01 * expected


def test_corners_are_on_the_surfaces_of_placed_bodies(ends_machine: Machine, draw_poses) -> None:
    """At poses, all corners of all bodies are as far from their hulls as the radius, those of telescopes, too."""
    drawn = draw_poses(ends_machine, 3, 4)
    meshes = {mesh.name: mesh for mesh in body_meshes(ends_machine)}
    frames = Frames.of(ends_machine, drawn.pose, drawn.q_m[:, :3])
    points = drawn_points(ends_machine, drawn.pose, drawn.q_m)
    assert {hull.name for hull in body_hulls(ends_machine)} == set(meshes)
    for hull in body_hulls(ends_machine):
        if hull.endless:
            continue
        placed = frames.points(hull)
        for k in range(len(drawn.pose)):
            here = replace(points, **{name: getattr(points, name)[k] for name in vars(points)})
            corners = mesh_frame(meshes[hull.name], drawn.pose[k], here).place(meshes[hull.name])
            distances = hull_separation(corners.T[None], placed[..., k, None] * np.ones(len(corners))).distance_m
            within = hull.name.startswith("rod")
            assert distances.max() <= hull.radius_m + 1e-9
            assert within or distances.min() == pytest.approx(hull.radius_m, abs=1e-9)


def test_what_is_endless_ends_near_the_machine(bodies_machine: Machine, bodies_config: Config, vary) -> None:
    """Rails are a little longer than travel; a wide floor is cut, and a far wall is drawn all the same."""
    meshes = {mesh.name: mesh for mesh in body_meshes(bodies_machine)}
    rail, floor = (meshes[name].vertices_m for name in ("rail2", "floor"))
    assert bodies_machine.travel_m.min() - 0.2 < rail[:, 0].min() < bodies_machine.travel_m.min()
    assert bodies_machine.travel_m.max() < rail[:, 0].max() < bodies_machine.travel_m.max() + 0.2
    assert np.abs(rail[:, 1:] - bodies_machine.rails_m[1]).max() == pytest.approx(0.02, abs=1e-3)
    assert np.abs(floor[:, 1]).max() < 1.5
    assert floor[:, 2].max() == pytest.approx(-0.15)
    wall = {"name": "wall", "attached_to": "frame", "beam": {"points_m": [[5.0, -1.0], [5.0, 3.0]], "radius_m": 0.1}}
    far = build_machine(vary(bodies_config, {"machine.bodies": [wall]}).machine)
    (mesh,) = (mesh for mesh in body_meshes(far) if mesh.name == "wall")
    assert mesh.vertices_m[:, 1].min() == pytest.approx(4.9)
    assert np.ptp(mesh.vertices_m[:, 2]) < 2.5


def test_pieces_make_up_the_whole(bodies_machine: Machine) -> None:
    """Long bodies in pieces reach as far as in one; what is within a tube is left out of its rod."""
    whole, pieces = (body_meshes(bodies_machine, pieces=count) for count in (1, 5))
    assert len(pieces) > len(whole)
    for mesh in whole:
        parts = [piece.vertices_at(1.2) for piece in pieces if piece.name == mesh.name]
        corners = mesh.vertices_at(1.2)
        np.testing.assert_allclose(np.vstack(parts).min(axis=0), corners.min(axis=0), atol=1e-9)
        np.testing.assert_allclose(np.vstack(parts).max(axis=0), corners.max(axis=0), atol=1e-9)
    rod, tube = (next(mesh for mesh in whole if mesh.name == f"{what} 2b") for what in ("rod", "tube"))
    assert rod.vertices_at(1.2)[:, 2].min() == pytest.approx(0.8 - 0.015)
    assert tube.vertices_at(1.2)[:, 2].max() == pytest.approx(0.8 + 0.02)


def test_axes_have_no_surface(machine: Machine, bodies_config: Config, vary) -> None:
    """A machine without bodies has none, and links without a radius are left out."""
    assert body_meshes(machine) == ()
    changed = vary(bodies_config, {"machine.link_bodies": None, "machine.clearance.link_link_m": 0.03})
    bare = build_machine(changed.machine)
    assert {mesh.kind for mesh in body_meshes(bare)} == {FrameKind.PLATFORM, FrameKind.CART, FrameKind.FIXED}


def test_obstacles_are_drawn_whole(bodies_config: Config, bodies_machine: Machine, quick_config: Config, vary) -> None:
    """What stands in the task is drawn beside the frame's own; only floors and walls are seen through."""
    workpiece = {"name": "workpiece", "box": {"centre_m": [1.0, -0.1, 0.7], "size_m": [0.4, 0.3, 0.2]}}
    task = vary(bodies_config, {"task.obstacles": [workpiece]})
    meshes = {mesh.name: mesh for mesh in body_meshes(bodies_machine, obstacles_of(task))}
    corners = meshes["workpiece"].vertices_m
    np.testing.assert_allclose(
        [corners.min(axis=0), corners.max(axis=0)], [[0.8, -0.25, 0.6], [1.2, 0.05, 0.8]], atol=1e-3
    )
    assert {name for name, mesh in meshes.items() if mesh.is_around} == {"floor"}
    assert set(meshes) - {"workpiece"} == {mesh.name for mesh in body_meshes(bodies_machine)}
    # Without any other body, links are axes and the platform is a point: neither has a surface.
    bare = vary(quick_config, {"task.obstacles": [workpiece]})
    assert [mesh.name for mesh in body_meshes(build_machine(bare.machine), obstacles_of(bare))] == ["workpiece"]
