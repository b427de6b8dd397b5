"""Poses from two reflectors: exact without noise, the least squares with it, and error bars that are right."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine.pose import CONTROLLED
from pipeline.measured import Reflectors, estimate_poses, reflector_positions

POINTS = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05]])
SLANTED = np.array([[0.08, 0.05, -0.04], [-0.10, 0.35, 0.12]])
POSE = np.array([[1.02, 0.6, 0.7, -0.35, 0.8, -0.25]])

coordinate = st.floats(-0.5, 0.5)
point = st.tuples(coordinate, coordinate, coordinate)
tilt = st.floats(-1.0, 1.0)
poses = st.tuples(st.floats(0.0, 2.0), coordinate, coordinate, tilt, st.floats(-3.0, 3.0), tilt)


def estimate(points: FloatArray, positions: FloatArray, pose: FloatArray, noise_m: float = 1e-4) -> FloatArray:
    """Estimate controlled poses near given ones."""
    return estimate_poses(Reflectors(points, noise_m), positions, pose).controlled


@given(first=point, second=point, pose=poses)
def test_without_noise_the_pose_comes_back(
    first: tuple[float, ...], second: tuple[float, ...], pose: tuple[float, ...]
) -> None:
    """Wherever two reflectors determine rz at all, all five coordinates are recovered to 1e-9."""
    points, true = np.array([first, second]), np.array([pose])
    assume(np.linalg.norm(points[1] - points[0]) > 0.05)
    try:
        found = estimate(points, reflector_positions(points, true), true)
    except UsageError:
        assume(False)
    assert np.abs(found - true[:, CONTROLLED]).max() < 1e-9


@given(off=st.tuples(*[st.floats(-0.1, 0.1)] * 5))
def test_of_the_command_ry_alone_matters(off: tuple[float, ...]) -> None:
    """A command that is off in everything but ry leads to the same estimate."""
    commanded = POSE.copy()
    commanded[:, CONTROLLED] += off
    found = estimate(SLANTED, reflector_positions(SLANTED, POSE), commanded)
    assert np.abs(found - POSE[:, CONTROLLED]).max() < 1e-9


@given(ry=st.floats(-3.0, 3.0))
def test_along_y_not_even_ry_matters(ry: float) -> None:
    """With reflectors along the platform's y axis a wrong ry leaves rx and rz right."""
    commanded = POSE.copy()
    commanded[:, 4] = ry
    found = estimate(POINTS, reflector_positions(POINTS, POSE), commanded)
    assert np.abs(found - POSE[:, CONTROLLED])[:, 3:].max() < 1e-9


@pytest.mark.parametrize("points", [POINTS, SLANTED])
def test_with_noise_it_is_the_least_squares(points: FloatArray) -> None:
    """The closed form agrees with a minimiser over all five unknowns and all six coordinates."""
    positions = reflector_positions(points, POSE) + np.random.default_rng(1).normal(0.0, 2e-3, (1, 2, 3))

    def misses(controlled: FloatArray) -> FloatArray:
        pose = POSE.copy()
        pose[:, CONTROLLED] = controlled
        return (reflector_positions(points, pose) - positions).ravel()

    best = least_squares(misses, POSE[0, CONTROLLED], xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(estimate(points, positions, POSE)[0] - best).max() < 1e-7


@pytest.mark.parametrize("points", [POINTS, SLANTED])
def test_error_bars_are_those_of_the_linearised_estimate(points: FloatArray) -> None:
    """Standard deviations follow from the estimate's own derivatives, by central differences of all six coordinates."""
    positions = reflector_positions(points, POSE)
    step = 1e-6
    shifts = step * np.eye(6).reshape(6, 2, 3)
    above, below = (estimate(points, positions + sign * shifts, np.tile(POSE, (6, 1))) for sign in (1.0, -1.0))
    expected = 1e-4 * np.linalg.norm((above - below) / (2.0 * step), axis=0)
    std = estimate_poses(Reflectors(points, 1e-4), positions, POSE).std[0]
    assert std == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("points", [POINTS, SLANTED])
@pytest.mark.parametrize("noise_m", [2e-5, 5e-4])
def test_standardised_errors_have_unit_variance(points: FloatArray, noise_m: float) -> None:
    """Over 20,000 noisy measurements at different poses, errors over their error bars have mean 0 and variance 1."""
    random = np.random.default_rng(7)
    count = 20_000
    low, high = [0.5, -0.2, 0.4, -0.5, -1.5, -0.5], [1.5, 0.9, 1.2, 0.5, 1.5, 0.5]
    pose = random.uniform(low, high, (count, 6))
    positions = reflector_positions(points, pose) + random.normal(0.0, noise_m, (count, 2, 3))
    found = estimate_poses(Reflectors(points, noise_m), positions, pose)
    standardised = (found.controlled - pose[:, CONTROLLED]) / found.std
    # Five standard deviations of the mean and of the variance of 20,000 normal numbers.
    assert np.abs(standardised.mean(axis=0)).max() < 5.0 / np.sqrt(count)
    assert np.abs(standardised.var(axis=0) - 1.0).max() < 5.0 * np.sqrt(2.0 / count)


def test_angles_are_known_as_well_as_the_reflectors_are_apart() -> None:
    """Along y, without tilt, rx and rz have the noise of a difference over the distance: sqrt(2) sigma / |d|."""
    flat = np.array([[1.0, 0.3, 0.9, 0.0, 0.7, 0.0]])
    for distance in (0.1, 0.3):
        points = np.array([[0.0, 0.0, 0.0], [0.0, distance, 0.0]])
        std = estimate_poses(Reflectors(points, 1e-4), reflector_positions(points, flat), flat).std[0]
        assert std[3:] == pytest.approx(np.sqrt(2.0) * 1e-4 / distance)


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        ((0.0, 0.1, 0.05), "in one place"),
        ((0.3, 0.1, 0.05), "do not determine rz"),
        ((0.0, 0.1, 0.35), "do not determine rz"),
    ],
)
def test_reflectors_that_determine_nothing(second: tuple[float, ...], expected: str) -> None:
    """In one place, or along the platform's x or z axis without tilt, reflectors are refused with the reason."""
    points = np.array([(0.0, 0.1, 0.05), second])
    flat = np.array([[1.0, 0.3, 0.9, 0.0, 0.0, 0.0]])
    with pytest.raises(UsageError, match=expected):
        estimate(points, reflector_positions(points, flat), flat)


@pytest.mark.parametrize(
    ("seen", "said"),
    [
        (lambda positions: 1e3 * positions, "300 m apart"),
        (lambda positions: positions[:, [0, 0]], "0 m apart"),
        (lambda positions: positions[:, ::-1], "points the wrong way"),
    ],
    ids=["millimetres", "the same twice", "exchanged"],
)
def test_what_cannot_have_been_seen_is_refused(seen: Callable[[FloatArray], FloatArray], said: str) -> None:
    """Positions in another unit, the same reflector twice, and swapped reflectors are distinguished from noise."""
    positions = seen(reflector_positions(POINTS, POSE))
    with pytest.raises(UsageError, match=said):
        estimate(POINTS, positions, POSE)


def test_much_noise_is_not_refused() -> None:
    """A tracker as bad as it says it is may see distances that are far off."""
    positions = reflector_positions(POINTS, POSE) + np.array([[0.0, 0.0, 0.0], [0.0, 0.04, 0.0]])
    assert np.isfinite(estimate(POINTS, positions, POSE, noise_m=0.02)).all()
    with pytest.raises(UsageError, match="apart"):
        estimate(POINTS, positions, POSE, noise_m=1e-4)
