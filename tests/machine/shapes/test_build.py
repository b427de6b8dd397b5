"""Which pairs of bodies are checked, and which touch by construction."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.machine.geometry import LINKS
from pipeline.machine.shapes.model import Bodies, FrameKind

BALL = {"capsule": {"from_m": [0.0, 0.0, 0.0], "to_m": [0.0, 0.0, 0.0], "radius_m": 0.02}}


def bodies_of(config: Config) -> Bodies:
    """Build the bodies of a configuration that has some."""
    found = build_machine(config.machine).bodies
    assert found is not None
    return found


def test_a_machine_without_bodies_has_none(machine: Machine) -> None:
    """Nothing is added to machines that declare nothing."""
    assert machine.bodies is None


def test_neighbours_follow_from_the_machine(bodies_machine: Machine) -> None:
    """A rib and the link it holds, a saddle and its rail, links with a common joint; and nothing far from a joint."""
    assert bodies_machine.bodies is not None
    found = {one.name: one.treatment for one in bodies_machine.bodies.neighbours}
    assert found["rib3a and link 3a"] == found["nose and link 3a"] == "checked beyond 0.08 m from it"
    assert found["saddle1 and link 1"] == found["rail3 and link 3c"] == "checked beyond 0.12 m from it"
    assert found["saddle2 and rail2"] == found["link 3a and link 3c"] == "not checked"
    assert not {"spine and link 2a", "rail1 and link 2a", "saddle1 and link 2a"} & set(found)


def test_joints_that_a_calibration_tells_apart_are_still_shared(bodies_config: Config, vary) -> None:
    """Links 3a and 3c have one cart joint to within clearance.shared_joint_m, and are a pair if it is less."""
    off = {"machine.links.l3c.length_m": 1.2567, "machine.links.l3c.cart_offset_m": [2e-4, -3e-4, 1e-4]}
    near, strict = (
        bodies_of(vary(bodies_config, {**off, "machine.clearance.shared_joint_m": most})) for most in (0.002, 1e-4)
    )
    assert "link 3a and link 3c" not in near.names
    assert "they share a joint" in {one.why for one in near.neighbours if one.name == "link 3a and link 3c"}
    assert "link 3a and link 3c" in strict.names
    assert near.names == bodies_of(bodies_config).names


def test_every_other_pair_of_two_frames_is_checked_once(bodies_machine: Machine) -> None:
    """What moves together is no pair, nor are carts and what is endless along X."""
    bodies = bodies_machine.bodies
    assert bodies is not None
    assert len(set(bodies.names)) == len(bodies.names) == len(bodies.pairs)
    frames = {"spine": "platform", "rib1": "platform", "nose": "platform", "saddle1": "cart1", "arm2": "cart2"}
    for one, other in (("spine", "saddle1"), ("nose", "arm2"), ("saddle1", "arm2")):
        assert f"{one} and {other}" in bodies.names
        assert frames[one] != frames[other]
    assert not {"spine and rib1", "rail1 and rail2", "saddle1 and floor", "rod 2b and tube 2b"} & set(bodies.names)
    assert {"rod 2b and rod 3b", "link 2a and tube 2b", "spine and floor", "rail2 and link 3a"} <= set(bodies.names)


def test_links_are_cut_short_against_their_neighbours_alone(bodies_machine: Machine) -> None:
    """8 cm at the platform, 12 cm at the cart, and whole against all others."""
    bodies = bodies_machine.bodies
    assert bodies is not None
    for name, cut in (
        ("rib2a and link 2a", (0.0, -0.08)),
        ("arm2 and link 2a", (0.12, 0.0)),
        ("spine and link 2a", (0.0, 0.0)),
    ):
        link = bodies.hulls[bodies.pairs[bodies.names.index(name)][1]]
        assert link.kind == FrameKind.LINK
        np.testing.assert_allclose(link.points_m[:, 1], cut)


def test_without_bodies_links_are_axes(quick_config: Config, vary) -> None:
    """Pairs of links are then left to clearance.link_link_m."""
    body = {"name": "ball", "attached_to": "platform", **BALL}
    bodies = bodies_of(vary(quick_config, {"machine.bodies": [body]}))
    assert bodies.names == tuple(f"ball and link {name}" for name in LINKS)
    assert {hull.radius_m for hull in bodies.hulls} == {0.02, 0.0}


def test_ignored_pairs_are_left_out_and_told(bodies_config: Config, vary) -> None:
    """Whichever is named first; both halves of a telescope have its name."""
    config = vary(bodies_config, {"machine.clearance.ignore": [["l1", "nose"], ["arm3", "l2b"]]})
    bodies = bodies_of(config)
    gone = {"nose and link 1", "arm3 and rod 2b", "arm3 and tube 2b"}
    assert not gone & set(bodies.names)
    assert gone <= {one.name for one in bodies.neighbours if one.why == "machine.clearance.ignore"}


def test_a_cart_that_is_always_too_close_is_a_pair(bodies_config: Config, vary) -> None:
    """It does not move towards the floor, but a floor within it is no neighbour."""
    config = vary(bodies_config, {"machine.bodies.16.beam.points_m": [[-3.0, -0.04], [3.0, -0.04]]})
    assert "saddle3 and floor" in bodies_of(config).names
    assert "saddle1 and floor" not in bodies_of(config).names


@pytest.mark.parametrize(
    ("shape", "points", "radius"),
    [
        ({"box": {"centre_m": [0.1, 0.0, 0.0], "size_m": [0.2, 0.1, 0.1], "rounding_m": 0.01}}, 8, 0.01),
        ({"box": {"size_m": [0.2, 0.1, 0.1], "rounding_m": 0.05}}, 2, 0.05),
        ({"hull": {"points_m": [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]], "radius_m": 0.02}}, 3, 0.02),
        (BALL, 1, 0.02),
    ],
)
def test_shapes_are_hulls_with_a_radius(quick_config: Config, vary, shape, points: int, radius: float) -> None:
    """The rounding of a box is inside it; a box as thin as its rounding is a capsule."""
    bodies = bodies_of(vary(quick_config, {"machine.bodies": [{"name": "it", "attached_to": "platform", **shape}]}))
    hull = bodies.hulls[0]
    assert hull.points_m.shape == (points, 3)
    assert hull.radius_m == radius
    if "box" in shape:
        low = np.array(shape["box"].get("centre_m", [0.0] * 3)) - np.array(shape["box"]["size_m"]) / 2.0
        np.testing.assert_allclose(hull.points_m.min(axis=0) - radius, low, atol=1e-15)
