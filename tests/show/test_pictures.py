"""The machine, the map and the task as shapes: where they are, and how they are turned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pipeline.config import BoxConfig, Config
from pipeline.figures.maps.kappa_map import kappa_map
from pipeline.machine import Machine
from pipeline.machine.drawing import drawn_points, rail_ends
from pipeline.machine.geometry import link_lengths
from pipeline.show.map_picture import map_picture, map_window
from pipeline.show.marks import shown_box, task_marks
from pipeline.show.orientation import pose_quaternion, tilt_quaternion, tilts_of
from pipeline.show.rods import PLATFORM, Rods, arm_colours, machine_rods, rail_rods, rod_count, unit_cylinder

ANGLES = st.floats(-1.4, 1.4)


@given(ANGLES, ANGLES, st.floats(-3.0, 3.0))
def test_tilts_are_read_from_any_orientation(rx: float, rz: float, ry: float) -> None:
    """Tilts come back, whatever ry is, and from the tilt alone."""
    pose = np.array([0.0, 0.0, 0.0, rx, ry, rz])
    np.testing.assert_allclose(tilts_of(pose_quaternion(pose)), (rx, rz), atol=1e-7)
    np.testing.assert_allclose(tilts_of(tilt_quaternion(pose)), (rx, rz), atol=1e-7)


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 1e-3))
def test_a_rod_is_a_cylinder_turned_and_stretched(direction: list[float]) -> None:
    """The ends of a cylinder along z come to lie at both ends of the rod, in any direction."""
    start = np.array([0.3, -0.2, 0.1])
    rod = Rods(start[None], (start + direction)[None], np.array([0.01]), np.zeros((1, 3), dtype=np.int64))
    turned = Rotation.from_quat(rod.wxyz[0], scalar_first=True)
    ends = start + turned.apply(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) * rod.scales[0])
    np.testing.assert_allclose(ends, [start, start + direction], atol=1e-9)


def test_a_rod_downwards() -> None:
    """Straight down is a half turn, not a division by zero."""
    rod = Rods(np.zeros((1, 3)), np.array([[0.0, 0.0, -2.0]]), np.array([0.01]), np.zeros((1, 3), dtype=np.int64))
    down = Rotation.from_quat(rod.wxyz[0], scalar_first=True).apply([0.0, 0.0, 2.0])
    np.testing.assert_allclose(down, [0.0, 0.0, -2.0], atol=1e-12)


def test_the_cylinder_is_closed_and_faces_outwards() -> None:
    """Faces enclose the volume of a prism with as many sides, positive if they face outwards."""
    vertices, faces = unit_cylinder(20)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    volume = (np.cross(a, b) * c).sum() / 6.0
    assert volume == pytest.approx(10.0 * np.sin(np.pi / 10.0))


def test_rods_are_the_links(machine: Machine, draw_poses) -> None:
    """Fixed links have their lengths, a tube and its rod together that of the telescope; all hold together."""
    sample = draw_poses(machine, 3)
    points = drawn_points(machine, sample.pose[0], sample.q_m[0])
    rods = machine_rods(machine, sample.pose[0, :3], points, arm_colours((-1.0, 1.0, -1.0), alarmed=False), PLATFORM)
    lengths = link_lengths(machine, sample.q_m[0, 3:])
    np.testing.assert_allclose(rods.lengths_m[:4], lengths[[0, 1, 3, 5]])
    np.testing.assert_allclose(rods.lengths_m[4:6] + rods.lengths_m[6:8], lengths[[2, 4]])
    np.testing.assert_array_equal(rods.ends_m[4:6], rods.starts_m[6:8])
    assert len(rods.radii_m) == len(rods.colours) == rod_count(machine) == 20
    assert (rods.colours[0] != rods.colours[1]).any()
    np.testing.assert_array_equal(rail_rods(machine).ends_m, rail_ends(machine)[:, 1])


def test_bodies_take_the_place_of_rods(bodies_machine: Machine, draw_poses) -> None:
    """Where links and platform have bodies, rods are the beams of the carts alone."""
    sample = draw_poses(bodies_machine, 3)
    points = drawn_points(bodies_machine, sample.pose[0], sample.q_m[0])
    colours = arm_colours((-1.0, 1.0, -1.0), alarmed=False)
    rods = machine_rods(bodies_machine, sample.pose[0, :3], points, colours, PLATFORM)
    np.testing.assert_array_equal(rods.ends_m, points.cart_joints_m)
    assert rod_count(bodies_machine) == 6


def test_alarm_is_one_colour() -> None:
    """Sides have colours of their own, unless something is wrong."""
    calm, alarmed = (arm_colours((-1.0, 1.0, -1.0), state) for state in (False, True))
    assert (calm[0] == calm[2]).all()
    assert (calm[0] != calm[1]).any()
    assert (alarmed == alarmed[0]).all()


def test_the_map_is_that_of_the_figures(machine: Machine, quick_config: Config) -> None:
    """Pixels are opaque exactly where the map has a value, z upwards; loops are where det H changes its sign."""
    tilt, mode = (0.1, -0.2), 5
    picture = map_picture(quick_config, machine, tilt, mode)
    window = map_window(quick_config, machine)
    height, width, _ = picture.image.shape
    found = kappa_map(
        machine,
        np.linspace(window.y_least, window.y_largest, width),
        np.linspace(window.z_least, window.z_largest, height),
        tilt,
        mode,
    )
    known = np.isfinite(found.kappa)
    assert 0 < known.sum() < known.size
    np.testing.assert_array_equal(picture.image[::-1, :, 3] > 128, known)
    assert bool(len(picture.loops_yz)) == found.has_singularities


def test_marks_share_a_place(quick_config: Config, machine: Machine, vary) -> None:
    """Start and goal at one place are one mark with both modes; a box without ends is cut to what is shown."""
    (mark,) = task_marks(quick_config)
    assert mark.title == "start LLL, goal RRR"
    visit = {"pose": {**quick_config.task.start.model_dump(), "x_m": 1.2}}
    assert [one.title for one in task_marks(vary(quick_config, {"task.visit": [visit]}))][1] == "visit[0] LLL"
    window = map_window(quick_config, machine)
    low, high = shown_box(BoxConfig(y_m=(0.1, 0.2)), machine, window)
    np.testing.assert_allclose([low[1], high[1]], [0.1, 0.2])
    np.testing.assert_allclose([low[2], high[2]], [window.z_least, window.z_largest])
    assert low[0] < machine.travel_m.min()
    assert high[0] > machine.travel_m.max()
