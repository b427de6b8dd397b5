"""Distances of convex hulls: against closed forms, another library and a quadratic program."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize

from pipeline.machine.clearance import segment_distance
from pipeline.machine.shapes.gjk import hull_separation

CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))


def stacked(hulls: np.ndarray) -> np.ndarray:
    """Store hulls (n, k, 3) as the pipeline does."""
    return np.ascontiguousarray(np.moveaxis(hulls, 0, -1))


def distances(first: np.ndarray, second: np.ndarray, **options: float) -> np.ndarray:
    """Measure pairs of hulls (n, k, 3)."""
    return hull_separation(stacked(first), stacked(second), **options).distance_m


def drawn(seed: int, count: int, points: int) -> np.ndarray:
    """Draw hulls of different sizes, (count, points, 3)."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, points, 3)) * rng.uniform(0.05, 0.5, (count, 1, 1)) + rng.normal(size=(count, 1, 3))


@pytest.mark.parametrize(("j", "k"), [(1, 1), (1, 2), (2, 2)])
def test_segments_have_the_distance_of_the_closed_form(j: int, k: int) -> None:
    """Points are segments without length."""
    first, second = drawn(1, 2_000, j), drawn(2, 2_000, k)
    p, u, q, v = first[:, 0], first[:, -1] - first[:, 0], second[:, 0], second[:, -1] - second[:, 0]
    np.testing.assert_allclose(distances(first, second), segment_distance(p, u, q, v), atol=1e-11)


@pytest.mark.parametrize(("j", "k"), [(1, 8), (2, 4), (3, 3), (4, 12), (8, 8), (12, 6)])
def test_both_bounds_of_the_distance_meet(j: int, k: int) -> None:
    """The normal separates the hulls by their distance, and no point of one is nearer to any of the other."""
    first, second = stacked(drawn(3, 800, j)), stacked(drawn(4, 800, k))
    found = hull_separation(first, second)
    apart = found.distance_m > 0.0
    heights = [np.einsum("cn,kcn->kn", found.normal, hull) for hull in (first, second)]
    np.testing.assert_allclose(
        (heights[0].min(axis=0) - heights[1].max(axis=0))[apart], found.distance_m[apart], atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=0)[apart], 1.0, atol=1e-12)
    assert not found.normal[:, ~apart].any()
    nearest = np.linalg.norm(first[:, None] - second[None], axis=2).min(axis=(0, 1))
    assert (found.distance_m <= nearest + 1e-12).all()
    assert np.count_nonzero(apart) > 500


def test_a_quadratic_program_finds_the_same_points() -> None:
    """Weights of the points on the simplex, found by a general solver."""
    first, second = drawn(5, 12, 5), drawn(6, 12, 6)
    for a, b, found in zip(first, second, distances(first, second), strict=True):
        D = np.vstack([a, -b])
        result = minimize(
            lambda w, D=D: float(np.sum((w @ D) ** 2)),
            np.concatenate([np.full(5, 0.2), np.full(6, 1.0 / 6.0)]),
            jac=lambda w, D=D: 2.0 * (D @ (w @ D)),
            bounds=[(0.0, 1.0)] * 11,
            constraints=[
                {"type": "eq", "fun": lambda w: w[:5].sum() - 1.0},
                {"type": "eq", "fun": lambda w: w[5:].sum() - 1.0},
            ],
            options={"ftol": 1e-15, "maxiter": 500},
        )
        assert found == pytest.approx(np.sqrt(result.fun), abs=1e-5)


def test_another_library_agrees() -> None:
    """Coal, where it is installed: 10,000 pairs to 1e-9."""
    coal = pytest.importorskip("coal", reason="coal is not installed: make consumers")

    def shape(points: np.ndarray) -> object:
        vector = coal.StdVec_Vec3s()
        vector.extend(points)
        return coal.ConvexBase.convexHull(vector, False, "")

    request, none = coal.DistanceRequest(), coal.Transform3s.Identity()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-12, 1_000
    for seed, (j, k) in enumerate(product((4, 6, 8, 12), repeat=2)):
        first, second = drawn(10 + seed, 625, j), drawn(50 + seed, 625, k)
        for a, b, mine in zip(first, second, distances(first, second), strict=True):
            theirs = max(coal.distance(shape(a), none, shape(b), none, request, coal.DistanceResult()), 0.0)
            assert mine == pytest.approx(theirs, abs=1e-9)


@pytest.mark.parametrize(
    ("shift", "expected"),
    [
        ([1.5, 0.0, 0.0], 0.5),
        ([1.5, 1.5, 0.0], np.hypot(0.5, 0.5)),
        ([1.5, 1.5, 1.5], 0.5 * np.sqrt(3.0)),
        ([1.5, 0.3, -0.2], 0.5),
        ([1.0, 0.0, 0.0], 0.0),
        ([1.0, 1.0, 1.0], 0.0),
        ([0.9, 0.2, 0.1], 0.0),
        ([0.0, 0.0, 0.0], 0.0),
    ],
)
def test_parallel_boxes(shift: list[float], expected: float) -> None:
    """Faces, edges and corners opposite each other, touching, and one inside the other: there the distance is zero."""
    found = distances(CORNERS[None] + shift, CORNERS[None])[0]
    assert found == pytest.approx(expected, abs=1e-12)


def test_parallel_and_collinear_segments() -> None:
    """Beside, behind, overlapping and the same."""
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    shifts = np.array([[0.3, 0.2, 0.0], [1.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.0], [1.3, 0.0, 0.4]])
    found = distances(line + shifts[:, None], np.broadcast_to(line, (5, 2, 3)))
    np.testing.assert_allclose(found, [0.2, 0.5, 0.0, 0.0, 0.5], atol=1e-12)


def test_deep_overlap_has_no_depth() -> None:
    """Distances of overlapping hulls are zero however deep, without a direction."""
    found = hull_separation(stacked(CORNERS[None] * 3.0 + 0.1), stacked(CORNERS[None]))
    assert found.distance_m[0] == 0.0
    assert not found.normal.any()


def test_gradients_are_those_of_differences() -> None:
    """As points move the distance changes by n . (da - db), of the points that are nearest."""
    first, second = drawn(7, 400, 8), drawn(8, 400, 8) + [3.0, 0.0, 0.0]
    velocity = np.random.default_rng(9).normal(size=(400, 1, 3))
    found = hull_separation(stacked(first), stacked(second))
    step = 1e-6
    ahead, behind = (distances(first + sign * step * velocity, second) for sign in (1.0, -1.0))
    slope = np.einsum("cn,nc->n", found.normal, velocity[:, 0])
    np.testing.assert_allclose((ahead - behind) / (2.0 * step), slope, atol=2e-5)


def test_far_pairs_are_not_pursued() -> None:
    """Beyond what is asked for a lower bound will do; nearer pairs are exact."""
    first, second = drawn(11, 500, 8), drawn(12, 500, 8)
    exact, bound = distances(first, second), distances(first, second, beyond_m=0.5)
    near = exact <= 0.5
    np.testing.assert_allclose(bound[near], exact[near], atol=1e-11)
    assert ((bound[~near] > 0.5) & (bound[~near] <= exact[~near] + 1e-12)).all()
    assert 50 < np.count_nonzero(near) < 450
