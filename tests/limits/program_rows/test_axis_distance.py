"""Separating vectors."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.arrays import FloatArray
from pipeline.limits.interface.rows import Nodes
from pipeline.limits.program_rows.axis_distance import (
    Separations,
    apartness,
    find_separations,
    separation_part,
    shortest_connection,
)
from pipeline.machine import Machine, link_rail_distances
from pipeline.machine.clearance import link_pairs, rail_pairs, segment_distance
from pipeline.machine.geometry import cart_joints, link_vectors
from pipeline.machine.kinematics import inverse_kinematics
from pipeline.machine.samples import PoseSamples
from tests.rails import off_x

# Squares of lengths below 1e-100 m would underflow: they are zero.
VECTORS = arrays(float, (1, 3), elements=st.floats(-1.0, 1.0).map(lambda x: x if abs(x) > 1e-100 else 0.0))


@pytest.fixture(scope="module")
def samples(machine: Machine) -> PoseSamples:
    """Give twelve poses in one working mode."""
    s = np.linspace(0.0, 1.0, 12)
    y, z = 0.3 + 0.2 * s, 0.9 - 0.2 * np.sin(np.pi * s)
    controlled = np.column_stack([0.9 + 0.0 * s, y, z, 0.1 * s, -0.1 * s])
    solution = inverse_kinematics(machine, controlled, np.zeros(12, dtype=int))
    assert np.isfinite(solution.q_m).all()
    return PoseSamples(machine, solution.pose, solution.q_m)


def _nodes(samples: PoseSamples, margin_m: float, reach_m: float) -> Nodes:
    k = len(samples)
    return Nodes(ca.MX.sym("pose", 6, k), ca.MX.sym("q", 5, k), samples, np.zeros((k, 5)), margin_m, reach_m)


def _links(samples: PoseSamples, margin_m: float, reach_m: float) -> Separations:
    pairs = link_pairs(samples.machine)
    return find_separations(pairs, False, samples.link_distances_m, 0.03, _nodes(samples, margin_m, reach_m))


def _rail_distances(samples: PoseSamples) -> FloatArray:
    return link_rail_distances(samples.machine, samples.pose, samples.carts_m)


def _rails(samples: PoseSamples, margin_m: float, reach_m: float) -> Separations:
    pairs = rail_pairs(samples.machine)
    return find_separations(pairs, True, _rail_distances(samples), 0.05, _nodes(samples, margin_m, reach_m))


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
    """For the unit vector along it n . (a - b) is at least the distance: the condition is exact, not conservative."""
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
    """Where the closest points are not unique, the vector between any of them separates as well."""
    q, v = p + along * u + shift, length * u
    connection = shortest_connection(p, u, q, v)[0]
    distance = np.linalg.norm(connection)
    if distance < 1e-3:
        return
    reach = [float(connection @ (a - b)) / distance for a in (p[0], p[0] + u[0]) for b in (q[0], q[0] + v[0])]
    assert min(reach) == pytest.approx(segment_distance(p, u, q, v)[0], abs=1e-6)


def test_pairs_within_reach_are_kept_apart_at_inner_nodes_only(samples: PoseSamples) -> None:
    """The given ends are left out; a wide reach includes all fourteen pairs everywhere between."""
    wide = _links(samples, 0.001, 10.0)
    assert len(wide) == 14 * 10
    assert set(wide.nodes.tolist()) == set(range(1, 11))
    assert wide.least_m == pytest.approx(0.031)
    assert len(_links(samples, 0.001, 0.0)) == 0


def test_rows_of_rails_off_x_are_never_above_the_distance(machine: Machine) -> None:
    """Whatever the vectors are, within their bounds; those of the guess are nearly the best there are."""
    skewed = off_x(machine, largest=0.005)
    solution = inverse_kinematics(skewed, np.tile([0.9, 0.35, 0.8, 0.1, -0.1], (3, 1)), np.zeros(3, dtype=int))
    samples = PoseSamples(skewed, solution.pose, solution.q_m)
    nodes, found = _nodes(samples, 0.0, 10.0), _rails(samples, 0.0, 10.0)
    normal = ca.MX.sym("n", 3, len(found))
    rows = ca.Function("rows", [nodes.pose, nodes.q, normal], [apartness(skewed, found, nodes.pose, nodes.q, normal)])
    turned = np.random.default_rng(1).uniform(-1.0, 1.0, found.normal.shape) * [0.0, 1.0, 1.0]
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    distances = _rail_distances(samples)[1]
    for normals, is_best in ((found.normal, True), (turned, False)):
        values = np.array(rows(samples.pose.T, samples.q_m.T, normals.T)).reshape(2, -1).min(axis=0) + found.least_m
        assert (values <= distances + 1e-12).all()
        assert not is_best or values == pytest.approx(distances, abs=1e-4)


def test_vectors_from_rails_have_no_x(samples: PoseSamples) -> None:
    """A rail is endless along X."""
    found = _rails(samples, 0.0, 10.0)
    assert len(found) == 12 * 10
    np.testing.assert_array_equal(found.normal[:, 0], 0.0)
    assert found.least_m == pytest.approx(0.05)


def test_the_vectors_separate_links_from_rails_by_their_distance(samples: PoseSamples) -> None:
    """For both ends of a link n . (end - rail) is at least the distance, in the plane across the rails."""
    machine, found = samples.machine, _rails(samples, 0.0, 10.0)
    begin, vector = cart_joints(machine, samples.carts_m), link_vectors(machine, samples.pose, samples.carts_m)
    distances = _rail_distances(samples)
    for row, (node, link, rail) in enumerate(zip(found.nodes, found.first, found.second, strict=True)):
        ends = np.stack([begin[node, link], begin[node, link] + vector[node, link]])[:, 1:] - machine.rails_m[rail]
        assert (ends @ found.normal[row, 1:]).min() == pytest.approx(
            distances[node, rail_pairs(machine).index((link, rail))], abs=1e-9
        )


@pytest.mark.parametrize("from_rail", [False, True])
def test_rows_are_the_distances_at_the_guess(samples: PoseSamples, from_rail: bool) -> None:
    """With the best separating vectors the least row of a pair is its distance less what is asked for."""
    nodes, pairs = _nodes(samples, 0.001, 10.0), (rail_pairs if from_rail else link_pairs)(samples.machine)
    distances, least = (_rail_distances(samples), 0.05) if from_rail else (samples.link_distances_m, 0.03)
    found = find_separations(pairs, from_rail, distances, least, nodes)
    part = separation_part("pairs", pairs, from_rail, distances, least, nodes)
    (own,), (apart, unit) = part.unknowns, part.rows
    evaluate = ca.Function("rows", [nodes.pose, nodes.q, own.symbol], [apart.expression, unit.expression])
    rows, lengths = (np.array(value).ravel() for value in evaluate(samples.pose.T, samples.q_m.T, own.guess.T))
    column = [pairs.index((a, b)) for a, b in zip(found.first, found.second, strict=True)]
    expected = distances[found.nodes, column] - least - 0.001
    np.testing.assert_allclose(rows.reshape(2 if from_rail else 4, -1).min(axis=0), expected, atol=1e-9)
    np.testing.assert_allclose(lengths, 1.0)
    assert (apart.low, unit.high) == (0.0, 1.0)
    np.testing.assert_array_equal(own.high[:, 0], 0.0 if from_rail else np.inf)
    assert np.isinf(own.high[:, 1:]).all()


def test_nothing_near_has_neither_rows_nor_unknowns(samples: PoseSamples) -> None:
    """Without a pair within reach the part is empty."""
    nodes, pairs = _nodes(samples, 0.0, 0.0), link_pairs(samples.machine)
    part = separation_part("pairs", pairs, False, samples.link_distances_m, 0.0, nodes)
    assert part.unknowns[0].symbol.numel() == 0
    assert [row.expression.numel() for row in part.rows] == [0, 0]
