"""A smooth condition number with its exact first and second derivatives, from singular values.

    kappa_p = |H|_p |H^-1|_p = (sum sigma_i^p)^(1/p) (sum sigma_i^-p)^(1/p)

with Schatten norms: kappa_2 <= kappa_p <= 6^(2/p) kappa_2. Where two singular values meet kappa_2 has a kink, and
kappa_p has none. The derivatives are those of a function of singular values under a perturbation of its matrix: with
H = U S V' and A = U' (dH) V, those of log kappa_p are phi_i A_ii to first order, and to second order the second
derivatives in the singular values with, for every pair i < j,

    ((phi_i - phi_j) / (sigma_i - sigma_j) (A_ij + A_ji)^2 + (phi_i + phi_j) / (sigma_i + sigma_j) (A_ij - A_ji)^2) / 2.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray

_SIZE = 6
_I, _J = np.triu_indices(_SIZE, 1)
_MEETING = 1e-6
"""Singular values closer than this, relative to their sum, count as one: a difference quotient would be noise."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A smooth condition number of matrices H (k, 6, 6), and what its derivatives are made of.

    Attributes
    ----------
    kappa : (k,)
        The condition number.
    gradient : (k, 6, 6)
        Its derivative by every entry of H.
    """

    kappa: FloatArray
    gradient: FloatArray
    _left: FloatArray
    _right: FloatArray
    _by_values: FloatArray
    _apart: FloatArray
    _together: FloatArray

    def curvature(self, H_derivatives: FloatArray) -> FloatArray:
        """Second derivatives of kappa along n directions of H, given (k, n, 6, 6), H being linear. Shape (k, n, n)."""
        A = np.einsum("kli,knlm,kmj->knij", self._left, H_derivatives, self._right, optimize=True)
        diagonal = np.einsum("knii->kni", A)
        plus, minus = (A[..., _I, _J] + sign * A[..., _J, _I] for sign in (1.0, -1.0))
        result: FloatArray = diagonal @ self._by_values @ _transposed(diagonal)
        for factor, part in ((self._apart, plus), (self._together, minus)):
            result += (part * factor[:, None]) @ _transposed(part) / 2.0
        return result * self.kappa[:, None, None]


def smooth_condition(H: FloatArray, exponent: float) -> Spectrum:
    """Take the Schatten condition number of matrices H (k, 6, 6) for an exponent of at least 2."""
    left, sigma, right = np.linalg.svd(H)
    right = _transposed(right)
    # Relative to the largest and to the least no power overflows.
    high, low = (sigma / sigma[:, :1]) ** exponent, (sigma[:, -1:] / sigma) ** exponent
    high_sum, low_sum = high.sum(axis=1), low.sum(axis=1)
    kappa = sigma[:, 0] / sigma[:, -1] * (high_sum * low_sum) ** (1.0 / exponent)
    share, inverse_share = high / high_sum[:, None], low / low_sum[:, None]
    phi = (share - inverse_share) / sigma
    # The derivative of phi_i by sigma_i with both sums held; they bring the products of shares.
    phi_slope = ((exponent - 1.0) * share + (exponent + 1.0) * inverse_share) / sigma**2
    products = share[:, :, None] * share[:, None] + inverse_share[:, :, None] * inverse_share[:, None]
    by_values = -exponent * products / (sigma[:, :, None] * sigma[:, None])
    by_values[:, range(_SIZE), range(_SIZE)] += phi_slope
    # log kappa to kappa: d2 kappa = kappa (d2 log kappa + d log kappa d log kappa').
    by_values += phi[:, :, None] * phi[:, None]
    gap, total = sigma[:, _I] - sigma[:, _J], sigma[:, _I] + sigma[:, _J]
    meeting = gap <= _MEETING * total
    apart = (phi[:, _I] - phi[:, _J]) / np.where(meeting, 1.0, gap)
    gradient = kappa[:, None, None] * ((left * phi[:, None]) @ _transposed(right))
    return Spectrum(
        kappa=kappa,
        gradient=gradient,
        _left=left,
        _right=right,
        _by_values=by_values,
        _apart=np.where(meeting, (phi_slope[:, _I] + phi_slope[:, _J]) / 2.0, apart),
        _together=(phi[:, _I] + phi[:, _J]) / total,
    )


def _transposed(A: FloatArray) -> FloatArray:
    swapped: FloatArray = np.swapaxes(A, -1, -2)
    return swapped
