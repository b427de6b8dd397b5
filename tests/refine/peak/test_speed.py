"""Speed along s of an iterate, and at its ends."""

import numpy as np

from pipeline.machine.pose import CONTROLLED
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.peak.speed import chord_curvature, chord_slopes, speed_constraints


def test_speeds_are_relative_to_the_mean(points: EvaluationPoints, iterate: Iterate, free: np.ndarray) -> None:
    """Rows say by how much of the mean speed a chord is above half of it, and above one and a half times it."""
    speeds = next(iter(speed_constraints(points, free, iterate)))
    relative = iterate.distances / np.diff(points.s) / iterate.distances.sum()
    np.testing.assert_allclose(speeds.value, np.concatenate([relative - 0.5, relative - 1.5]))


def test_an_end_with_a_direction_moves_along_it_and_not_across(
    points: EvaluationPoints, iterate: Iterate, free: np.ndarray
) -> None:
    """Its least speed is required in that direction, whichever way the leg still points; four equations are added."""
    given = free.copy()
    given[1] = [1.0, 0.0, 0.0, 0.0, 0.0]
    without, with_one = (list(speed_constraints(points, ends, iterate)) for ends in (free, given))
    assert [len(part.value) for part in with_one] == [*(len(part.value) for part in without), 4]
    leg = iterate.coefficients[-1] - iterate.coefficients[-2]
    along, across = with_one[-2:]
    np.testing.assert_allclose(along.value, leg[:1])
    np.testing.assert_allclose(np.linalg.norm(across.value), np.linalg.norm(leg[1:]))
    np.testing.assert_allclose(along.low, without[-1].low)


def test_curvature_is_that_of_the_length_of_moved_chords(
    points: EvaluationPoints, iterate: Iterate, direction: np.ndarray
) -> None:
    """Second differences of weighted distances, poses moving linearly with the coefficients; never negative."""
    weights = np.linspace(1.0, 2.0, len(iterate.distances))
    step = np.append(direction.ravel(), [0.0, 0.0])
    shift = np.einsum("kij,kj->ki", iterate.moves, points.basis @ direction)
    moved = np.diff(shift[:, CONTROLLED], axis=0) / points.steps
    h = 1e-4

    def length(part: float) -> float:
        return float(weights @ np.linalg.norm(iterate.chords + part * moved, axis=1))

    curvature = chord_curvature(points, iterate, weights)
    expected = (length(h) - 2.0 * length(0.0) + length(-h)) / h**2
    np.testing.assert_allclose(step @ (curvature @ step), expected, rtol=1e-4)
    np.testing.assert_allclose(
        weights @ (chord_slopes(points, iterate) @ step), (length(h) - length(-h)) / (2 * h), rtol=1e-4
    )
    assert np.linalg.eigvalsh(curvature.toarray()).min() > -1e-9 * np.abs(curvature.toarray()).max()
