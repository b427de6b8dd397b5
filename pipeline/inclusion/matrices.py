"""Matrices and vectors of balls, and bounds of their absolute values."""

import numpy as np
from flint import arb, arb_mat

from pipeline.arrays import FloatArray
from pipeline.inclusion.closure import Vector


def matrices(at: list[Vector], over: list[Vector], terms: int) -> list[arb_mat]:
    """Return coefficients of a matrix of series: about the middle, but the last one about the whole interval."""
    return [arb_mat([[entry[n] for entry in row] for row in (over if n + 1 == terms else at)]) for n in range(terms)]


def ball_matrix(matrix: FloatArray) -> arb_mat:
    """Convert a matrix of floats to exact balls."""
    return arb_mat([[arb(value) for value in row] for row in matrix.tolist()])


def floats(matrix: arb_mat) -> FloatArray:
    """Return the middles of a matrix of balls."""
    values = [float(entry.mid()) for entry in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())


def magnitudes(matrix: arb_mat) -> list[list[arb]]:
    """Bound the absolute values of a matrix of balls."""
    return [[entry.abs_upper() for entry in row] for row in matrix.table()]


def times(matrix: list[list[arb]], vector: list[arb]) -> list[arb]:
    """Multiply a matrix and a vector."""
    return [inner(row, vector) for row in matrix]


def inner(a: list[arb], b: list[arb]) -> arb:
    """Compute the scalar product of two vectors of any length."""
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))


def added(a: list[arb], b: list[arb]) -> list[arb]:
    """Add two vectors."""
    return [x + y for x, y in zip(a, b, strict=True)]


def upper_bounds(matrix: arb_mat) -> FloatArray:
    """Return floats that are not below the absolute values of a matrix of balls."""
    values = np.array([float(entry.abs_upper()) for entry in matrix.entries()])
    return enlarged(values).reshape(matrix.nrows(), matrix.ncols())


def upper_vector(values: list[arb]) -> FloatArray:
    """Return floats that are not below the absolute values of some balls."""
    return enlarged(np.array([float(value.abs_upper()) for value in values]))


def enlarged(bounds: FloatArray) -> FloatArray:
    """Enlarge bounds, not negative and computed with up to a thousand roundings of floats each, to certain ones."""
    return np.asarray(bounds * (1.0 + 1e-12) + 1e-290, dtype=float)
