"""Bodies in a parallel projection."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from pipeline.figures.silhouettes import AZIMUTH, ELEVATION, project, silhouettes
from pipeline.machine import Machine
from pipeline.machine.bodies.meshes import body_meshes, build_mesh, mesh_frame
from pipeline.machine.drawing import drawn_points
from pipeline.machine.shapes.model import FrameKind, SweptHull


def test_projection_is_seen_along_one_line() -> None:
    """A right-handed view keeps heights upright, and shortens nothing that lies across the line of sight."""
    x, y, z = project(np.eye(3))
    assert z[0] == pytest.approx(0.0)
    assert z[1] > 0.0
    np.testing.assert_allclose(np.outer(x, x) + np.outer(y, y) + np.outer(z, z), np.eye(2), atol=1e-12)


def test_outlines_hold_all_corners(bodies_machine: Machine, draw_poses) -> None:
    """Every corner of a body is projected within its outline, which consists of projected corners."""
    drawn = draw_poses(bodies_machine, 3, 1)
    pose, points = drawn.pose[0], drawn_points(bodies_machine, drawn.pose[0], drawn.q_m[0])
    found = silhouettes(body_meshes(bodies_machine), pose, points)
    assert {one.mesh.name for one in found} == {mesh.name for mesh in body_meshes(bodies_machine)}
    for one in found:
        seen = project(mesh_frame(one.mesh, pose, points).place(one.mesh))
        middle = one.outline.mean(axis=0)
        assert (Delaunay(middle + 1.000001 * (one.outline - middle)).find_simplex(seen) >= 0).all()
        assert all(np.abs(seen - corner).sum(axis=1).min() < 1e-12 for corner in one.outline)


def test_what_is_in_front_comes_last(bodies_machine: Machine, draw_poses) -> None:
    """Of balls in a row along the line of sight, and of a rod within a tube."""
    sight = np.array([np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)])
    balls = [SweptHull(str(k), FrameKind.FIXED, 0, (k * sight)[None], 0.1) for k in (2, 0, 1)]
    tube = [SweptHull(name, FrameKind.FIXED, 0, np.array([4 * sight, 4 * sight + [0, 0, 1]]), r) for name, r in
            (("tube", 0.2), ("rod", 0.1))]  # fmt: skip
    drawn = draw_poses(bodies_machine, 3, 1)
    points = drawn_points(bodies_machine, drawn.pose[0], drawn.q_m[0])
    found = silhouettes(tuple(build_mesh(hull) for hull in (*balls, *tube)), drawn.pose[0], points)
    assert [one.mesh.name for one in found] == ["0", "1", "2", "rod", "tube"]
