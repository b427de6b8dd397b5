"""PIQP, an interior-point method for sparse convex quadratic programs, called through CasADi."""

import casadi as ca
import numpy as np
from scipy.sparse import csc_array, csr_array

from pipeline.arrays import FloatArray


class DampedProgram:
    """A convex quadratic program, to be solved with different damping t of its unknowns x (n,).

        minimise    gradient . x + x . (hessian + t damping) x / 2
        subject to  low <= matrix x <= high,  lower <= x <= upper

    Parameters
    ----------
    hessian, damping : (n, n) sparse
        Symmetric; their sum has to be positive semidefinite for every t it is solved with.
    gradient : (n,)
    matrix : (m, n) sparse
    row_bounds, column_bounds : pair of (m,), pair of (n,)
        Least and largest; infinite where there is no limit.
    """

    def __init__(
        self,
        hessian: csr_array | csc_array,
        damping: csr_array | csc_array,
        gradient: FloatArray,
        matrix: csr_array | csc_array,
        row_bounds: tuple[FloatArray, FloatArray],
        column_bounds: tuple[FloatArray, FloatArray],
    ) -> None:
        self._hessian, self._damping = casadi_matrix(hessian), casadi_matrix(damping)
        self._gradient, self._matrix = gradient, casadi_matrix(matrix)
        self._rows, self._columns = row_bounds, column_bounds
        shapes = {"h": (self._damping + self._hessian).sparsity(), "a": self._matrix.sparsity()}
        self._solver = ca.conic("step", "piqp", shapes, {"error_on_fail": False})

    def solve(self, t: float) -> FloatArray | None:
        """Find the minimum with damping t, shape (n,); None where PIQP finds none."""
        result = self._solver(
            h=self._hessian + t * self._damping,
            g=self._gradient,
            a=self._matrix,
            lba=self._rows[0],
            uba=self._rows[1],
            lbx=self._columns[0],
            ubx=self._columns[1],
        )
        return np.array(result["x"]).ravel() if self._solver.stats()["success"] else None

    def value(self, x: FloatArray) -> float:
        """Evaluate the objective at x (n,) without damping."""
        return float(self._gradient @ x) + float(ca.bilin(self._hessian, x, x)) / 2.0


def casadi_matrix(matrix: csr_array | csc_array) -> ca.DM:
    """Convert a SciPy matrix with its sparsity; entries that are stored as zero stay."""
    columns = csc_array(matrix)
    columns.sum_duplicates()
    height, width = columns.shape
    return ca.DM(ca.Sparsity(height, width, columns.indptr.tolist(), columns.indices.tolist()), columns.data.tolist())
