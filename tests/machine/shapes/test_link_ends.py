"""Bodies at the ends of links: where they are, and which pairs of them are checked."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import are_clear, body_distances
from pipeline.machine.bodies.meshes import body_meshes
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.drawing import drawn_points
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies


@pytest.fixture(scope="module")
def bodies(ends_machine: Machine) -> Bodies:
    """Take the bodies and their pairs."""
    assert ends_machine.bodies is not None
    return ends_machine.bodies


def test_they_are_on_the_line_between_the_joints(ends_machine: Machine, bodies: Bodies, draw_poses) -> None:
    """At their distance from the joint they are attached to, whatever the length of the link."""
    drawn = draw_poses(ends_machine, 5, 20)
    frames, ends = (
        Frames.of(ends_machine, drawn.pose, drawn.q_m[:, :3]),
        drawn_points(ends_machine, drawn.pose, drawn.q_m),
    )
    for name, link, at_platform, along in (
        ("motor", 2, False, (0.15, 0.3)),
        ("stud", 2, True, (-0.06, 0.0)),
        ("collar", 3, True, (-0.2, -0.12)),
        ("ball", 0, False, (0.0, 0.0)),
    ):
        hull = next(hull for hull in bodies.hulls if hull.name == name)
        C, A = ends.cart_joints_m[:, link], ends.platform_joints_m[:, link]
        axis = (A - C) / np.linalg.norm(A - C, axis=1, keepdims=True)
        for point, metres in zip(frames.points(hull), along, strict=True):
            np.testing.assert_allclose(point.T, (A if at_platform else C) + metres * axis, atol=1e-12)


def test_pairs_follow_from_the_machine(bodies: Bodies) -> None:
    """With all others; what they touch by construction is cut away, and both ends of a telescope are a pair."""
    names, neighbours = set(bodies.names), {one.name: one.treatment for one in bodies.neighbours}
    assert {"stud and rod 3b", "motor and link 2a", "spine and motor", "ball and tube 3b", "stud and ball"} <= names
    # They slide: one is on the tube, and the other on the rod.
    assert {"stud and motor", "stud and tube 2b"} <= names
    assert not {"motor and tube 2b", "motor and rod 2b", "stud and rod 2b", "collar and link 3a"} & names
    # All of the stud is where the platform's rib is, but only the front of the motor where the cart's arm is.
    assert neighbours["rib2b and stud"] == "not checked"
    assert "rib2b and stud" not in names
    assert neighbours["saddle1 and ball"] == "not checked"
    assert "collar and link 3c" in names


def test_links_that_share_a_joint_are_not_checked_there(bodies_config: Config, vary) -> None:
    """3a and 3c have one on the cart: what is at it is on both; what is at the platform's end is not."""
    given = bodies_config.model_dump()["machine"]["bodies"]
    ball = {"from_m": [0.0, 0.0, 0.0], "to_m": [0.0, 0.0, 0.0], "radius_m": 0.02}
    ends = [{"name": f"at_{end}", "attached_to": f"l3a_{end}", "capsule": ball} for end in ("cart", "platform")]
    bodies = build_machine(vary(bodies_config, {"machine.bodies": [*given, *ends]}).machine).bodies
    assert bodies is not None
    assert "at_platform and link 3c" in bodies.names
    assert "at_cart and link 3c" not in bodies.names
    assert "they share a joint" in {one.why for one in bodies.neighbours if one.name == "at_cart and link 3c"}


def test_regions_keep_them_apart(ends_machine: Machine, bodies: Bodies, draw_poses) -> None:
    """What is told of many poses at a time is what distances say, those of spheres among them."""
    sample = draw_poses(ends_machine, 7, 300)
    drawn = PoseSamples(ends_machine, sample.pose, sample.q_m)
    distances = body_distances(bodies, drawn)
    clear = (distances >= bodies.clearance_m).all(axis=1)
    np.testing.assert_array_equal(are_clear(bodies, drawn), clear)
    own = [k for k, name in enumerate(bodies.names) if {"stud", "motor", "ball", "collar"} & set(name.split())]
    assert (distances[:, own] < bodies.clearance_m).any()


def test_links_without_bodies_keep_their_axes(ends_config: Config, vary) -> None:
    """Bodies at the ends of links that are axes otherwise are kept apart and drawn; axes are drawn as ever."""
    config = vary(ends_config, {"machine.link_bodies": None, "machine.clearance.link_link_m": 0.03})
    machine = build_machine(config.machine)
    assert machine.bodies is not None
    assert "motor and link 2a" in machine.bodies.names
    assert "link 1 and link 2a" not in machine.bodies.names
    meshes = body_meshes(machine)
    assert {"stud", "motor", "ball", "collar"} <= {mesh.name for mesh in meshes}
    assert not any(mesh.is_link for mesh in meshes)
    assert {hull.moves_with for hull in machine.bodies.hulls if hull.attached} == {"link 1", "link 2b", "link 3a"}
