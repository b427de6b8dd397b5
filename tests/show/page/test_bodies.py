"""Bodies in the scene of `show`: a node each, placed and coloured."""

import importlib.util
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.bodies.meshes import body_meshes, mesh_frame
from pipeline.machine.drawing import drawn_points
from pipeline.show.page.bodies import draw_bodies, move_bodies
from pipeline.show.rods import arm_colours

if TYPE_CHECKING:
    import viser

pytestmark = pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="viser is not installed")


@pytest.fixture(scope="module")
def server() -> Iterator["viser.ViserServer"]:
    """Start a server at any free port, for this machine alone."""
    import viser

    started = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield started
    started.stop()


def test_nodes_are_where_bodies_are(server: "viser.ViserServer", bodies_machine: Machine, draw_poses) -> None:
    """Turned and moved, the corners of every node are those of its body, of telescopes, too."""
    from scipy.spatial.transform import Rotation

    drawn = draw_poses(bodies_machine, 3, 1)
    pose, points = drawn.pose[0], drawn_points(bodies_machine, drawn.pose[0], drawn.q_m[0])
    nodes = draw_bodies(server.scene, bodies_machine, None)
    assert [body.mesh.name for body in nodes] == [mesh.name for mesh in body_meshes(bodies_machine)]
    calm = arm_colours((-1.0, 1.0, 1.0), alarmed=False)
    move_bodies(nodes, pose, points, calm, alarmed=False)
    for body in nodes:
        axes = Rotation.from_quat(body.node.wxyz, scalar_first=True).as_matrix()
        placed = body.node.position + body.node.vertices @ axes.T
        frame = mesh_frame(body.mesh, pose, points)
        np.testing.assert_allclose(placed, frame.place(body.mesh), atol=1e-6)
    colours = {body.mesh.name: tuple(body.node.color) for body in nodes}
    assert colours["saddle1"] == tuple(calm[0].tolist()) == colours["link 1"]
    assert colours["saddle2"] == tuple(calm[1].tolist()) == colours["link 2a"]
    assert len({colours[name] for name in ("link 2a", "tube 2b", "rod 2b", "spine", "rail1", "floor")}) == 6
    move_bodies(nodes, pose, points, arm_colours((-1.0, 1.0, 1.0), alarmed=True), alarmed=True)
    red = {body.mesh.name: tuple(body.node.color) for body in nodes}
    assert red["spine"] == red["link 1"] != colours["spine"]
