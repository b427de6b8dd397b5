"""Separating vectors."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.machine import Machine
from pipeline.machine.clearance import link_rail_distances, rail_pairs, segment_distance
from pipeline.machine.geometry import cart_joints, link_vectors
from pipeline.refine import Path
from pipeline.refine.integral.separation import find_separations, shortest_connection

VECTORS = arrays(float, (1, 3), elements=st.floats(-1.0, 1.0))


@given(p=VECTORS, u=VECTORS, q=VECTORS, v=VECTORS)
def test_the_shortest_connection_is_as_long_as_the_distance(
    p: np.ndarray, u: np.ndarray, q: np.ndarray, v: np.ndarray
) -> None:
    """It agrees with the distance of the segments, also for parallel and vanishing ones."""
    connection = shortest_connection(p, u, q, v)
    np.testing.assert_allclose(np.linalg.norm(connection, axis=1), segment_distance(p, u, q, v), atol=1e-7)


@given(p=VECTORS, u=VECTORS, q=VECTORS, v=VECTORS)
def test_its_direction_separates_all_end_points_by_the_distance(
    p: np.ndarray, u: np.ndarray, q: np.ndarray, v: np.ndarray
) -> None:
    """For the unit vector along it n . (a - b) is at least the distance: the condition is exact, not cautious."""
    connection = shortest_connection(p, u, q, v)[0]
    distance = np.linalg.norm(connection)
    if distance < 1e-3:
        return
    n = connection / distance
    reach = [float(n @ (a - b)) for a in (p[0], p[0] + u[0]) for b in (q[0], q[0] + v[0])]
    assert min(reach) >= distance - 1e-6


@given(p=VECTORS, u=VECTORS, shift=VECTORS, along=st.floats(-2.0, 2.0), length=st.floats(-2.0, 2.0))
def test_parallel_links_are_separated_by_their_distance(
    p: np.ndarray, u: np.ndarray, shift: np.ndarray, along: float, length: float
) -> None:
    """Where the closest points are not unique any of them gives the same separating vector's worth."""
    q, v = p + along * u + shift, length * u
    connection = shortest_connection(p, u, q, v)[0]
    distance = np.linalg.norm(connection)
    if distance < 1e-3:
        return
    reach = [float(connection @ (a - b)) / distance for a in (p[0], p[0] + u[0]) for b in (q[0], q[0] + v[0])]
    assert min(reach) == pytest.approx(segment_distance(p, u, q, v)[0], abs=1e-6)


def test_pairs_within_reach_are_watched_at_inner_nodes_only(machine: Machine, coarse: Path) -> None:
    """The given ends are left out; a wide reach watches all fourteen pairs everywhere between."""
    s = np.linspace(0.0, 1.0, 12)
    pose, q = coarse.pose(s), coarse.q(s)
    wide = find_separations(machine, pose, q, 0.001, 10.0)
    assert len(wide) == 14 * 10
    assert set(wide.node.tolist()) == set(range(1, 11))
    np.testing.assert_allclose(wide.distance_m, 0.031)
    assert len(find_separations(machine, pose, q, 0.001, 0.0)) == 0


def test_rails_are_watched_where_they_are_asked_for(machine: Machine, coarse: Path) -> None:
    """A rail is endless along X, so that its vector has no x."""
    s = np.linspace(0.0, 1.0, 12)
    found = find_separations(replace(machine, link_rail_m=0.05), coarse.pose(s), coarse.q(s), 0.0, 10.0)
    rails = found.of_rail
    assert rails.any()
    np.testing.assert_array_equal(found.normal[rails, 0], 0.0)
    np.testing.assert_allclose(found.distance_m[rails], 0.05)


def test_the_vectors_separate_links_from_rails_by_their_distance(machine: Machine, coarse: Path) -> None:
    """For both ends of a link n . (end - rail) is at least the distance, in the plane across the rails."""
    s = np.linspace(0.0, 1.0, 12)
    pose, q = coarse.pose(s), coarse.q(s)
    found = find_separations(replace(machine, link_rail_m=0.05), pose, q, 0.0, 10.0)
    begin, vector = cart_joints(machine, q[:, :3]), link_vectors(machine, pose, q[:, :3])
    distances = link_rail_distances(machine, pose, q[:, :3])
    for row in np.flatnonzero(found.of_rail):
        node, link, rail = found.node[row], found.first[row], found.second[row] - 6
        ends = np.stack([begin[node, link], begin[node, link] + vector[node, link]])[:, 1:] - machine.rails_m[rail]
        assert (ends @ found.normal[row, 1:]).min() == pytest.approx(
            distances[node, rail_pairs(machine).index((link, rail))], abs=1e-9
        )
