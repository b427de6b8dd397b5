"""Distances between links, and between links and rails, against independent minimisation."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import lsq_linear

from pipeline.arrays import FloatArray
from pipeline.machine import InverseSolution, Machine, link_distances, link_rail_distances, min_distances
from pipeline.machine.clearance import common_perpendicular, link_pairs, rail_pairs, segment_distance
from pipeline.machine.geometry import ARM_OF_LINK, LINKS, cart_joints, link_vectors

seeds = st.integers(0, 2**32 - 1)
points = arrays(float, 3, elements=st.floats(-1.0, 1.0, width=32))


def least_distance(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> float:
    """Minimise |p + s u - q - t v| over s, t in [0, 1]: a bounded linear least-squares problem."""
    fit = lsq_linear(np.column_stack([u, -v]), q - p, bounds=(0.0, 1.0), method="bvls", tol=1e-14)
    return float(np.linalg.norm(p - q + np.column_stack([u, -v]) @ fit.x))


def distance(p: object, u: object, q: object, v: object) -> float:
    """Distance of two segments, one pair at a time."""
    rows = [np.asarray(row, dtype=float)[None] for row in (p, u, q, v)]
    return float(segment_distance(*rows)[0])


@given(p=points, u=points, q=points, v=points)
@settings(max_examples=120)
def test_segment_distance_is_the_least_distance(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray):
    """No pair of points is nearer, whatever the segments: skew, parallel, crossing or of no length."""
    assert distance(p, u, q, v) == pytest.approx(least_distance(p, u, q, v), abs=2e-6)


@given(p=points, u=points, q=points, v=points)
def test_segment_distance_does_not_depend_on_order_or_direction(
    p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray
):
    """Swapping the segments, or the ends of one, changes nothing."""
    value = distance(p, u, q, v)
    assert distance(q, v, p, u) == pytest.approx(value, abs=1e-9)
    assert distance(p + u, -u, q, v) == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("p", "u", "q", "v", "expected"),
    [
        pytest.param([0, 0, 0], [2, 0, 0], [1, -1, 0], [0, 2, 0], 0.0, id="crossing"),
        pytest.param([0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 0], 0.0, id="sharing an end"),
        pytest.param([0, 0, 0], [2, 0, 0], [1, 0, 0], [0, 0, 1], 0.0, id="touching in the middle"),
        pytest.param([0, 0, 0], [2, 0, 0], [1, -1, 0.5], [0, 2, 0], 0.5, id="passing above"),
        pytest.param([0, 0, 0], [1, 0, 0], [4, 4, 0], [0, 0, 1], 5.0, id="beyond the end"),
        pytest.param([0, 0, 0], [1, 0, 0], [0.5, 0.25, 0], [1, 0, 0], 0.25, id="parallel, overlapping"),
        pytest.param([0, 0, 0], [1, 0, 0], [2, 1, 0], [1, 0, 0], np.sqrt(2.0), id="parallel, apart"),
        pytest.param([0, 0, 0], [1, 0, 0], [0.5, 0.25, 0], [-1, 0, 0], 0.25, id="antiparallel"),
        pytest.param([0, 0, 0], [3, 0, 0], [1, 0, 0], [1, 0, 0], 0.0, id="one within the other"),
        pytest.param([0, 0, 0], [1, 0, 0], [3, 0, 0], [1, 0, 0], 2.0, id="in line, apart"),
        pytest.param([0, 0, 0], [1, 0, 0], [0.5, 0.25, 1e-9], [1, 1e-8, 0], 0.25, id="parallel but for rounding"),
        pytest.param([0, 0, 0], [0, 0, 0], [1, -1, 0], [0, 2, 0], 1.0, id="a point and a segment"),
        pytest.param([0, 0, 0], [0, 0, 0], [3, 4, 0], [0, 0, 0], 5.0, id="two points"),
    ],
)
def test_segment_distance_in_special_positions(p, u, q, v, expected):
    """Crossing, touching, parallel and degenerate segments have the distance one reads off them."""
    assert distance(p, u, q, v) == pytest.approx(expected, abs=1e-9)


def test_common_perpendicular_has_a_sign_and_a_place():
    """The signed distance is along u x v, its feet are fractions of the vectors, and parallel lines have none."""
    p, u = np.array([[0.0, 0, 1], [0, 0, -1], [0, 0, 1]]), np.array([[2.0, 0, 0]] * 3)
    q, v = np.array([[0.5, -1.0, 0]] * 3), np.array([[0.0, 4, 0], [0, 4, 0], [3, 0, 0]])
    signed, s, t = common_perpendicular(p, u, q, v)
    np.testing.assert_allclose(signed, [1.0, -1.0, np.nan])
    np.testing.assert_allclose(s, [0.25, 0.25, np.nan])
    np.testing.assert_allclose(t, [0.25, 0.25, np.nan])


def test_pairs_leave_out_links_that_share_a_joint(machine: Machine):
    """Of the fifteen pairs only 3a-3c is left out; links that meet on the platform would be, too."""
    pairs = {(LINKS[a], LINKS[b]) for a, b in link_pairs(machine)}
    assert len(pairs) == 14
    assert ("3a", "3c") not in pairs
    points_m = machine.platform_points_m.copy()
    points_m[1] = points_m[0]
    meeting = {(LINKS[a], LINKS[b]) for a, b in link_pairs(replace(machine, platform_points_m=points_m))}
    assert pairs - meeting == {("1", "2a")}


@pytest.mark.parametrize(("apart_m", "shared"), [(1e-6, True), (2e-3, True), (2.1e-3, False)])
def test_joints_that_are_nearly_one_are_shared(machine: Machine, apart_m: float, shared: bool):
    """A calibrated machine has the joints of 3a and 3c a little apart; within the stated distance they are one."""
    offsets_m = machine.cart_offsets_m.copy()
    offsets_m[5, 0] += apart_m
    assert machine.shared_joint_m == 2e-3
    assert ((3, 5) not in link_pairs(replace(machine, cart_offsets_m=offsets_m))) is shared


def test_rail_pairs_leave_out_the_own_rail(machine: Machine):
    """Every link has the rails of the two other arms."""
    pairs = rail_pairs(machine)
    assert len(pairs) == 12
    assert all(ARM_OF_LINK[link] != rail for link, rail in pairs)


def test_least_link_distance_agrees_with_the_reference(
    machine: Machine, reference, reference_solution: InverseSolution
):
    """The least distance between links is that of the reference to 1e-9."""
    links, _ = min_distances(machine, reference_solution.pose, reference_solution.q_m[:, :3])
    np.testing.assert_allclose(links, reference.column("min_link_distance_m"), atol=1e-9)


@given(seed=seeds)
@settings(max_examples=8)
def test_link_distances_are_those_of_their_segments(machine: Machine, draw_poses: Callable, seed: int):
    """Every column is the least distance of its pair of links, cart joint to platform joint."""
    sample = draw_poses(machine, seed, 60)
    pose, carts = sample.pose[:3], sample.q_m[:3, :3]
    start, vector = cart_joints(machine, carts), link_vectors(machine, pose, carts)
    distances = link_distances(machine, pose, carts)
    for column, (a, b) in enumerate(link_pairs(machine)):
        for row in range(len(pose)):
            expected = least_distance(start[row, a], vector[row, a], start[row, b], vector[row, b])
            assert distances[row, column] == pytest.approx(expected, abs=1e-9)
    np.testing.assert_array_equal(min_distances(machine, pose, carts)[0], distances.min(axis=1))


def test_rail_distances_agree_with_dense_sampling(machine: Machine, reference_solution: InverseSolution):
    """A rail is an endless line along X, so that only the distance in the Y-Z plane counts."""
    pose, carts = reference_solution.pose[::5], reference_solution.q_m[::5, :3]
    start, vector = cart_joints(machine, carts), link_vectors(machine, pose, carts)
    along = np.linspace(0.0, 1.0, 4001)[:, None]
    distances = link_rail_distances(machine, pose, carts)
    for column, (link, rail) in enumerate(rail_pairs(machine)):
        for row in range(len(pose)):
            places = start[row, link, 1:] + along * vector[row, link, 1:]
            sampled = np.linalg.norm(places - machine.rails_m[rail], axis=1).min()
            assert distances[row, column] <= sampled + 1e-12
            assert distances[row, column] == pytest.approx(sampled, abs=2e-4)
    np.testing.assert_array_equal(min_distances(machine, pose, carts)[1], distances.min(axis=1))


def test_a_link_along_the_rails_is_a_point_beside_them(machine: Machine):
    """A link parallel to X has no extent across the rails: its distance is that of its joints."""
    pose = np.array([[2.0, 0.3, 1.5, 0.0, 0.0, 0.0]])
    level = replace(machine, platform_points_m=np.zeros((6, 3)), cart_offsets_m=np.array([[0.0, 0.3, 0.0]] * 6))
    column = rail_pairs(level).index((0, 1))
    distances = link_rail_distances(level, pose, np.zeros((1, 3)))
    assert distances[0, column] == pytest.approx(0.45)
