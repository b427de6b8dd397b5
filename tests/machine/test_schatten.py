"""The smooth condition number and its derivatives, against norms, CasADi's own derivatives and finite differences."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.machine.schatten import smooth_condition

seeds = st.integers(0, 2**32 - 1)
exponents = pytest.mark.parametrize("exponent", [2.0, 8.0, 64.0])


@exponents
@given(seed=seeds)
@settings(max_examples=25)
def test_it_is_the_product_of_two_schatten_norms(exponent: float, seed: int) -> None:
    """Norms of singular values; at most 6^(2 / p) above the condition number, and never below it."""
    H = np.random.default_rng(seed).normal(size=(20, 6, 6))
    sigma = np.linalg.svd(H, compute_uv=False)
    # Powers of the inverse alone overflow for matrices that are nearly singular.
    largest, least = sigma[:, :1], sigma[:, -1:]
    norms = [np.linalg.norm(scaled, ord=exponent, axis=1) for scaled in (sigma / largest, least / sigma)]
    expected = (largest / least)[:, 0] * norms[0] * norms[1]
    kappa = smooth_condition(H, exponent).kappa
    np.testing.assert_allclose(kappa, expected, rtol=1e-9)
    true = np.linalg.cond(H)
    assert (kappa >= true * (1.0 - 1e-12)).all()
    assert (kappa <= 6.0 ** (2.0 / exponent) * true * (1.0 + 1e-12)).all()


def test_at_exponent_two_it_is_the_frobenius_condition_number() -> None:
    """|H|_F |H^-1|_F."""
    H = np.random.default_rng(1).normal(size=(20, 6, 6))
    expected = np.linalg.norm(H, axis=(1, 2)) * np.linalg.norm(np.linalg.inv(H), axis=(1, 2))
    np.testing.assert_allclose(smooth_condition(H, 2.0).kappa, expected, rtol=1e-12)


def _by_casadi(exponent: int) -> ca.Function:
    """(H, directions (36, n)) -> gradient and second derivatives along the directions, by traces of powers."""
    entries, directions = ca.SX.sym("H", 36), ca.SX.sym("D", 36, 4)
    H = ca.reshape(entries, 6, 6)
    M = H.T @ H
    inverse = ca.solve(M, ca.SX.eye(6))
    powers = [M, inverse]
    for _ in range(int(np.log2(exponent)) - 1):
        powers = [power @ power for power in powers]
    kappa = (ca.trace(powers[0]) * ca.trace(powers[1])) ** (1.0 / exponent)
    bend, slope = ca.hessian(kappa, entries)
    return ca.Function("reference", [entries, directions], [slope, directions.T @ bend @ directions])


@pytest.mark.parametrize("exponent", [2, 8])
def test_derivatives_are_those_casadi_finds(exponent: int) -> None:
    """Gradient and second derivatives agree with differentiating traces of powers of H'H."""
    rng = np.random.default_rng(2)
    reference = _by_casadi(exponent)
    H, directions = rng.normal(size=(10, 6, 6)), rng.normal(size=(10, 4, 6, 6))
    spectrum = smooth_condition(H, float(exponent))
    curvature = spectrum.curvature(directions)
    for k in range(10):
        along = directions[k].transpose(2, 1, 0).reshape(36, 4)
        slope, bend = (np.array(part) for part in reference(H[k].T.ravel(), along))
        np.testing.assert_allclose(
            spectrum.gradient[k].T.ravel(), slope.ravel(), rtol=1e-6, atol=1e-8 * np.abs(slope).max()
        )
        np.testing.assert_allclose(curvature[k], bend, rtol=1e-5, atol=1e-7 * np.abs(bend).max())


@exponents
@pytest.mark.parametrize("sigma", [[3.0, 3.0, 2.0, 1.0, 0.5, 0.5], [2.0] * 6, [5.0, 4.0, 3.0, 2.0, 1.0, 1e-3]])
def test_derivatives_hold_where_singular_values_meet(exponent: float, sigma: list[float]) -> None:
    """Central differences agree where two values are equal, where all are, and far from both."""
    rng = np.random.default_rng(3)
    left, right = (np.linalg.qr(rng.normal(size=(6, 6)))[0] for _ in range(2))
    H, direction = left @ np.diag(sigma) @ right, rng.normal(size=(6, 6))
    direction *= min(sigma) / exponent
    step = 1e-4
    ahead, behind = (smooth_condition((H + sign * step * direction)[None], exponent) for sign in (1.0, -1.0))
    here = smooth_condition(H[None], exponent)
    slope = (ahead.kappa - behind.kappa)[0] / (2.0 * step)
    assert np.sum(here.gradient[0] * direction) == pytest.approx(slope, abs=1e-5 * here.kappa[0])
    bend = np.sum((ahead.gradient - behind.gradient)[0] * direction) / (2.0 * step)
    found = here.curvature(direction[None, None])[0, 0, 0]
    assert found == pytest.approx(bend, rel=1e-4, abs=1e-6 * here.kappa[0])


def test_nearly_singular_matrices_do_not_overflow() -> None:
    """Powers of singular values many orders apart stay finite."""
    H = np.diag([1e3, 1.0, 1.0, 1.0, 1.0, 1e-9])[None]
    spectrum = smooth_condition(H, 64.0)
    assert spectrum.kappa[0] == pytest.approx(1e12)
    assert np.isfinite(spectrum.curvature(np.ones((1, 1, 6, 6)))).all()
