"""Speed along s while the largest kappa goes down."""

import numpy as np

from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.peak.speed import chord_curvature, chord_slopes, pace_limits
from pipeline.route.metric import CONTROLLED


def test_speeds_are_relative_to_the_mean(looks: EvaluationPoints, iterate: Iterate, free: np.ndarray) -> None:
    """Rows say by how much of the mean speed a chord is above half of it, and above one and a half times it."""
    speeds = next(iter(pace_limits(looks, free, iterate)))
    relative = iterate.distances / np.diff(looks.s) / iterate.distances.sum()
    np.testing.assert_allclose(speeds.value, np.concatenate([relative - 0.5, relative - 1.5]))


def test_an_end_with_a_direction_moves_along_it_and_not_across(
    looks: EvaluationPoints, iterate: Iterate, free: np.ndarray
) -> None:
    """Its least speed is asked for in that direction, whichever way the leg points yet; four equations are added."""
    given = free.copy()
    given[1] = [1.0, 0.0, 0.0, 0.0, 0.0]
    without, with_one = (list(pace_limits(looks, ends, iterate)) for ends in (free, given))
    assert [len(limit.value) for limit in with_one] == [*(len(limit.value) for limit in without), 4]
    leg = iterate.coefficients[-1] - iterate.coefficients[-2]
    along, across = with_one[-2:]
    np.testing.assert_allclose(along.value, leg[:1])
    np.testing.assert_allclose(np.linalg.norm(across.value), np.linalg.norm(leg[1:]))
    np.testing.assert_allclose(along.low, without[-1].low)


def test_curvature_is_that_of_the_length_of_moved_chords(
    looks: EvaluationPoints, iterate: Iterate, direction: np.ndarray
) -> None:
    """Second differences of weighted distances, poses moving linearly with the coefficients; never negative."""
    weights = np.linspace(1.0, 2.0, len(iterate.distances))
    step = np.append(direction.ravel(), [0.0, 0.0])
    shift = np.einsum("kij,kj->ki", iterate.moves, (looks.spread @ direction.ravel()).reshape(-1, 5))
    moved = np.diff(shift[:, CONTROLLED], axis=0) / looks.steps
    h = 1e-4

    def length(part: float) -> float:
        return float(weights @ np.linalg.norm(iterate.chords + part * moved, axis=1))

    curvature = chord_curvature(looks, iterate, weights)
    expected = (length(h) - 2.0 * length(0.0) + length(-h)) / h**2
    np.testing.assert_allclose(step @ (curvature @ step), expected, rtol=1e-4)
    np.testing.assert_allclose(
        weights @ (chord_slopes(looks, iterate) @ step), (length(h) - length(-h)) / (2 * h), rtol=1e-4
    )
    assert np.linalg.eigvalsh(curvature.toarray()).min() > -1e-9 * np.abs(curvature.toarray()).max()
