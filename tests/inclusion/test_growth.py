"""How images grow with radii: the least radii that suffice, and none where none do."""

import numpy as np
import pytest
from flint import arb

from pipeline.inclusion.growth import LEAST_RADIUS, Growth, settle


def _one(constant: float, linear: float, quadratic: float) -> Growth:
    """Let every coordinate of k depend on its own radius alone."""
    G = np.zeros((6, 6, 6))
    G[np.arange(6), np.arange(6), np.arange(6)] = quadratic
    return Growth(np.full(6, constant), linear * np.eye(6), G)


@pytest.mark.parametrize("share", [1.0, 0.9])
def test_radii_solve_the_quadratic(share: float) -> None:
    """C + b r + g r^2 = share r has its smaller root for the least radius."""
    found = _one(1e-3, 0.2, 5.0).radius(share)
    b = share - 0.2
    exact = (b - np.sqrt(b * b - 4.0 * 5.0 * 1e-3)) / 10.0
    assert found is not None
    np.testing.assert_allclose(found, exact, rtol=1e-4)


@pytest.mark.parametrize(("constant", "linear", "quadratic"), [(1e-3, 1.0, 0.0), (0.02, 0.2, 9.0), (np.inf, 0.0, 0.0)])
def test_no_radii_are_found_where_there_are_none(constant: float, linear: float, quadratic: float) -> None:
    """An image that grows as fast as the radii, or faster, never fits into them."""
    assert _one(constant, linear, quadratic).radius(0.9) is None


def test_settled_radii_suffice_and_are_hardly_larger_than_they_have_to_be() -> None:
    """Where hulls widen the image, too; and above the floor that is given."""

    def grow(radius: np.ndarray) -> tuple[Growth, list[list[arb]]]:
        return _one(1e-3 * (1.0 + 20.0 * float(radius.max())), 0.1, 5.0), []

    floor = np.full(6, LEAST_RADIUS)
    found = settle((floor, floor), grow, [_one(1e-3, 0.1, 5.0)] * 2, arb(0.9))
    assert found is not None
    radius, image, _ = found
    k = np.array([float(value.upper()) for value in image])
    assert (k < 0.9 * radius).all()
    assert (k > 0.85 * radius).all()
    wide = settle((10.0 * radius, 10.0 * radius), grow, [_one(1e-3, 0.1, 5.0)] * 2, arb(0.9))
    assert wide is None or (wide[0] >= 10.0 * radius).all()
    assert settle((floor, floor), grow, [_one(1e-3, 1.0, 5.0)] * 2, arb(0.9)) is None
