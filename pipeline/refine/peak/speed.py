"""How a path is run through while its largest kappa is brought down: even speed along s, and what its ends ask for."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array, diags_array, hstack

from pipeline.arrays import FloatArray, IntArray
from pipeline.refine.integral.program import END_SPEED, SPEED_RANGE
from pipeline.refine.peak.constraints import Limit, of_actuators
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.splines import DEGREE
from pipeline.route.metric import CONTROLLED

_SPEED_SLACK = 0.05
"""Of the mean speed along s."""
_LEAST_END_SPEED = 0.1
"""Of the mean speed of the actuators along s: with less than 0.07 a path counts as one that nearly stops."""
_EXACT = 1e-9


def pace_limits(looks: EvaluationPoints, directions: FloatArray, iterate: Iterate) -> Iterator[Limit]:
    """Say what the speed along s has to keep, and the ends; `directions` (2, 5) as in `nlp.ProgramData`."""
    yield _least_and_largest_speed(looks, iterate)
    one = np.zeros(1)
    yield Limit(one, one, one, 1.0, lambda _: _by_length(looks, iterate))
    yield from _ends(looks, directions, iterate)


@lru_cache(maxsize=2)
def chord_slopes(looks: EvaluationPoints, iterate: Iterate) -> csr_array:
    """Differentiate the distances from look to look by the unknowns of a step. Shape (k - 1, 5 n + 2).

    The last answers are kept: limits, objective and its curvature ask for the same one.
    """
    towards = _towards(iterate)
    return csr_array(sum(_scaled(towards[:, axis], _chord_slopes(looks, iterate, axis)) for axis in range(5)))


def chord_curvature(looks: EvaluationPoints, iterate: Iterate, weights: FloatArray) -> csr_array:
    """Differentiate weights (k - 1,) . distances twice, the moves taken as linear: sum of w/d |across|^2. Square."""
    towards, along = _towards(iterate), chord_slopes(looks, iterate)
    scale = np.sqrt(weights / np.maximum(iterate.distances, 1e-12))
    across = (_chord_slopes(looks, iterate, axis) - _scaled(towards[:, axis], along) for axis in range(5))
    return csr_array(sum(rows.T @ rows for rows in (_scaled(scale, part) for part in across)))


def _towards(iterate: Iterate) -> FloatArray:
    unit: FloatArray = iterate.chords / np.maximum(iterate.distances, 1e-12)[:, None]
    return unit


def _chord_slopes(looks: EvaluationPoints, iterate: Iterate, axis: int) -> csr_array:
    """Differentiate one coordinate of the chords, in steps of the route. Shape (k - 1, 5 n + 2)."""
    by_q = iterate.moves[:, CONTROLLED[axis]] / looks.steps[axis]
    every = of_actuators(looks, np.arange(len(by_q)), by_q)
    return csr_array(every[1:] - every[:-1])


def _scaled(factor: FloatArray, rows: csr_array) -> csr_array:
    return csr_array(diags_array(factor) @ rows)


def _less_length(by_chord: csr_array, factor: FloatArray) -> csr_array:
    """Take `factor` (m,) times the length, the last unknown, off rows (m, 5 n + 2)."""
    width = by_chord.shape[1]
    return csr_array(by_chord - hstack([csr_array((len(factor), width - 1)), csr_array(factor[:, None])]))


def _by_length(looks: EvaluationPoints, iterate: Iterate) -> csr_array:
    """Say that the length changes by as much as the distances do together."""
    return _less_length(csr_array(chord_slopes(looks, iterate).sum(axis=0)[None]), np.ones(1))


def _least_and_largest_speed(looks: EvaluationPoints, iterate: Iterate) -> Limit:
    """Distance less a share of length * ds, in units of length * ds: not below zero, then not above."""
    distances, ds = iterate.distances, np.diff(looks.s)
    factor, scale = np.repeat(SPEED_RANGE, len(ds)), np.tile(float(distances.sum()) * ds, 2)
    relative = np.tile(distances, 2) / scale
    low = np.where(factor == SPEED_RANGE[0], 0.0, -np.inf)
    high = np.where(factor == SPEED_RANGE[1], 0.0, np.inf)

    def slope(rows: IntArray) -> csr_array:
        by_chord = chord_slopes(looks, iterate)
        by_step = _less_length(by_chord[rows % len(ds)], (relative * np.tile(ds, 2))[rows])
        return _scaled(1.0 / scale[rows], by_step)

    return Limit(relative - factor, low, high, _SPEED_SLACK, slope)


def _ends(looks: EvaluationPoints, directions: FloatArray, iterate: Iterate) -> Iterator[Limit]:
    """Speed of the actuators at both ends, and the directions that they leave the start and come to the goal in."""
    t, c, q, s = looks.knots, iterate.coefficients, iterate.q_m, looks.s
    means = ((q[1] - q[0]) / (s[1] - s[0]), (q[-1] - q[-2]) / (s[-1] - s[-2]))
    paces = (DEGREE / (t[DEGREE + 1] - t[0]), DEGREE / (t[-1] - t[-DEGREE - 2]))
    travelled = float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum())
    for first, direction, mean, pace in zip((0, len(c) - 2), directions, means, paces, strict=True):
        leg = c[first + 1] - c[first]
        least = max(END_SPEED * float(np.linalg.norm(mean)), _LEAST_END_SPEED * travelled) / pace
        given = bool(np.isfinite(direction).all())
        along = direction if given else leg / max(float(np.linalg.norm(leg)), 1e-12)
        yield _along_leg(along[None], first, leg, len(c), least, np.inf, max(0.1 * least, _EXACT))
        if given:
            yield _along_leg(null_space(direction[None]).T, first, leg, len(c), 0.0, 0.0, _EXACT)


def _along_leg(
    axes: FloatArray, first: int, leg: FloatArray, coefficients: int, low: float, high: float, slack: float
) -> Limit:
    """Keep what a leg of the control polygon, from coefficient `first` on, has along axes (m, 5) within bounds."""
    slope = np.zeros((len(axes), 5 * coefficients + 2))
    slope[:, 5 * first : 5 * first + 10] = np.hstack([-axes, axes])
    ones = np.ones(len(axes))
    return Limit(axes @ leg, low * ones, high * ones, slack, lambda rows: csr_array(slope[rows]))
