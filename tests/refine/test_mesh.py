"""Meshes: where they get finer, and in which order what they miss goes away."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pipeline.refine import Path, Refinement, kappa_along
from pipeline.refine.mesh import Mesh, adapted_mesh, even_mesh, largest_part, with_nodes
from pipeline.refine.splines import DEGREE, clamped_knots, fit
from pipeline.route.metric import arc_length

NONE = np.zeros(0)


def test_it_is_even_with_further_nodes_where_asked_for() -> None:
    """Twenty nodes, one of them doubled by a visit elsewhere, and as many coefficients as given."""
    mesh = even_mesh(20, 9, np.array([0.5]))
    assert len(mesh.s) == 21
    assert 0.5 in mesh.s
    assert mesh.coefficients == 9


def test_a_node_takes_the_place_of_one_that_is_nearly_there() -> None:
    """No two nodes are nearer than a quarter of the spacing, the ends stay."""
    mesh = even_mesh(21, 9, np.array([0.1 + 1e-13, 0.511, 0.725]))
    assert np.diff(mesh.s).min() > 0.2 * 0.05
    assert {0.0, 0.1 + 1e-13, 0.511, 0.725, 1.0} <= set(mesh.s.tolist())
    assert len(mesh.s) == 22


def test_nodes_are_added_where_a_requirement_is_broken() -> None:
    """In the middle of the interval with the violation, once, however many there are in it."""
    mesh = even_mesh(11, 8, NONE)
    more = with_nodes(mesh, np.array([0.31, 0.33, 0.36]))
    np.testing.assert_allclose(np.setdiff1d(more.s, mesh.s), [0.35])
    np.testing.assert_array_equal(more.knots, mesh.knots)


def test_knots_go_where_the_spline_is_rough(refinement: Refinement, steps: np.ndarray) -> None:
    """A bump on one coefficient draws the new knots to the spans it reaches."""
    mesh = even_mesh(80, 24, NONE)
    smooth = fit(mesh.knots, np.linspace(0, 1, 400), refinement.path.q(np.linspace(0, 1, 400)))
    smooth[15] += 0.03
    path = Path(refinement.path.machine, BSpline(mesh.knots, smooth, DEGREE), mesh.s, refinement.path.pose(mesh.s))
    more = adapted_mesh(mesh, path, steps)
    new = np.setdiff1d(more.knots, mesh.knots)
    inside = (new > mesh.knots[15]) & (new < mesh.knots[15 + DEGREE + 1])
    assert inside.sum() >= 2
    assert set(mesh.s) < set(more.s)
    assert more.coefficients == mesh.coefficients + len(new)


def test_the_integral_on_nodes_converges_with_order_two(refinement: Refinement, steps: np.ndarray) -> None:
    """What the trapezoidal rule over chords misses falls to a quarter when nodes are doubled."""
    path = refinement.path

    def integral(nodes: int) -> float:
        s = np.linspace(0.0, 1.0, nodes)
        return float(np.trapezoid(kappa_along(path, s), arc_length(path.pose(s), steps)))

    exact = integral(50_001)
    errors = np.abs([integral(nodes) - exact for nodes in (201, 401, 801)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.3)


def test_splines_converge_with_order_six() -> None:
    """The distance to a smooth curve falls to a 64th when knots are doubled."""
    s = np.linspace(0.0, 1.0, 4_001)
    curve = np.stack([np.sin((3.0 + k) * s + k) for k in range(5)], axis=1)
    errors = []
    for spans in (8, 16, 32):
        knots = clamped_knots(spans + DEGREE)
        errors.append(np.abs(BSpline(knots, fit(knots, s, curve), DEGREE)(s) - curve).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 6.0, atol=0.5)


def test_what_has_no_error_is_not_marked() -> None:
    """Neighbours with the same error are marked together, and none where there is no error at all."""
    assert not largest_part(np.zeros(4)).any()
    np.testing.assert_array_equal(largest_part(np.array([3.0, 3.0, 1.0, 0.0])), [True, True, False, False])


@pytest.mark.parametrize("rounds", [1, 3])
def test_finer_meshes_hold_the_coarser_ones(refinement: Refinement, steps: np.ndarray, rounds: int) -> None:
    """Every mesh has the nodes and knots of the one before, so that no start is lost."""
    spline = refinement.path.spline
    mesh = before = Mesh(np.linspace(0.0, 1.0, 50), spline.t)
    path = replace(refinement.path)
    for _ in range(rounds):
        before, mesh = mesh, adapted_mesh(mesh, path, steps)
        assert np.isin(before.s, mesh.s).all()
        assert np.isin(before.knots, mesh.knots).all()
