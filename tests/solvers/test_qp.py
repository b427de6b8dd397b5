"""Convex quadratic programs with damping, solved by PIQP."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_array, csr_array

from pipeline.solvers import DampedProgram
from pipeline.solvers.qp import casadi_matrix


def _program(seed: int, equalities: int = 0) -> tuple[DampedProgram, dict[str, np.ndarray]]:
    """Draw a program of six unknowns with a Hessian of rank three; its first rows are equalities."""
    random = np.random.default_rng(seed)
    root, matrix = random.normal(size=(3, 6)), random.normal(size=(4, 6))
    matrix[np.abs(matrix) < 0.5] = 0.0
    inside = matrix @ random.uniform(-0.5, 0.5, 6)
    slack = np.where(np.arange(4) < equalities, 0.0, 0.3)
    given_ = {
        "hessian": root.T @ root,
        "damping": np.diag(random.uniform(0.5, 2.0, 6)),
        "gradient": random.normal(size=6),
        "matrix": matrix,
        "low": inside - slack,
        "high": inside + slack,
    }
    program = DampedProgram(
        csc_array(given_["hessian"]),
        csr_array(given_["damping"]),
        given_["gradient"],
        csr_array(matrix),
        (given_["low"], given_["high"]),
        (np.full(6, -1.0), np.ones(6)),
    )
    return program, given_


@settings(max_examples=40)
@given(st.integers(0, 1_000_000), st.integers(0, 3), st.floats(0.01, 100.0))
def test_nothing_feasible_is_better_than_the_solution(seed: int, equalities: int, damping: float) -> None:
    """The solution keeps all limits, and its gradient rises towards every other feasible point, as convexity has it."""
    program, data = _program(seed, equalities)
    x = program.solve(damping)
    assert x is not None
    rows = data["matrix"] @ x
    assert (rows >= data["low"] - 1e-6).all()
    assert (rows <= data["high"] + 1e-6).all()
    assert np.abs(x).max() <= 1.0 + 1e-6
    slope = data["gradient"] + (data["hessian"] + damping * data["damping"]) @ x
    random = np.random.default_rng(seed)
    tried = random.uniform(-1.0, 1.0, (2_000, 6))
    # Towards x until it is feasible: the feasible set is convex and x is in it.
    for share in (1.0, 0.1, 0.01):
        points = x + share * (tried - x)
        across = points @ data["matrix"].T
        feasible = ((across >= data["low"]) & (across <= data["high"])).all(axis=1)
        assert ((points[feasible] - x) @ slope >= -1e-5 * (1.0 + np.abs(slope).max())).all()


def test_more_damping_makes_a_shorter_step() -> None:
    """Without other limits in the way, the solution is that of the linear equations."""
    zero = csr_array((1, 2))
    free = (np.full(2, -np.inf), np.full(2, np.inf))
    hessian, damping, gradient = np.array([[2.0, 1.0], [1.0, 2.0]]), np.eye(2), np.array([1.0, -3.0])
    program = DampedProgram(csc_array(hessian), csc_array(damping), gradient, zero, (np.zeros(1), np.zeros(1)), free)
    lengths = []
    for t in (0.0, 1.0, 10.0):
        x = program.solve(t)
        assert x is not None
        np.testing.assert_allclose(x, -np.linalg.solve(hessian + t * damping, gradient), atol=1e-6)
        lengths.append(float(np.linalg.norm(x)))
    assert lengths == sorted(lengths, reverse=True)


def test_the_value_leaves_damping_out() -> None:
    """It is g . x + x . H x / 2."""
    program, data = _program(3)
    x = np.linspace(-1.0, 1.0, 6)
    expected = data["gradient"] @ x + x @ data["hessian"] @ x / 2.0
    assert program.value(x) == pytest.approx(expected)


def test_limits_that_exclude_each_other_have_no_solution() -> None:
    """At most 1 each and at least 3 in all."""
    program = DampedProgram(
        csc_array((2, 2)),
        csc_array(np.eye(2)),
        np.zeros(2),
        csc_array(np.ones((1, 2))),
        (np.array([3.0]), np.array([np.inf])),
        (np.full(2, -1.0), np.ones(2)),
    )
    assert program.solve(1.0) is None


def test_a_matrix_is_converted_with_its_sparsity() -> None:
    """Entries that were stored twice are added up, stored zeros stay."""
    matrix = csc_array((np.array([1.0, 2.0, 0.0, 5.0]), (np.array([0, 0, 1, 2]), np.array([0, 0, 1, 1]))), shape=(3, 2))
    converted = casadi_matrix(matrix)
    assert converted.nnz() == 3
    np.testing.assert_array_equal(np.array(converted), [[3.0, 0.0], [0.0, 0.0], [0.0, 5.0]])
