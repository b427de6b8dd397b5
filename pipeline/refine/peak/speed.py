"""How an iterate moves along s: evenly, and at its ends fast enough and in the configured directions."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from scipy.linalg import null_space
from scipy.sparse import csr_array, diags_array, hstack

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.pose import CONTROLLED
from pipeline.refine.integral.program import END_SPEED, SPEED_RANGE
from pipeline.refine.one_way import OneWayLeg
from pipeline.refine.peak.constraints import Constraint, by_unknowns
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.splines import DEGREE

_SPEED_SLACK = 0.05
"""Share of the mean speed along s."""
_LEAST_END_SPEED = 0.1
"""Share of the mean speed of the actuators along s: below 0.07 a path counts as one that nearly stops."""
_EXACT, _NO_DISTANCE = 1e-9, 1e-12
_ONE_WAY_SLACK_M = 1e-4


def speed_constraints(points: EvaluationPoints, directions: FloatArray, iterate: Iterate) -> Iterator[Constraint]:
    """Write what the speed along s and the ends have to keep; `directions` (2, 5) as in `ProgramData`."""
    yield _speed_range(points, iterate)
    one = np.zeros(1)
    yield Constraint(one, one, one, 1.0, lambda _: _length_balance(points, iterate))
    yield from _ends(points, directions, iterate)


@lru_cache(maxsize=2)
def chord_slopes(points: EvaluationPoints, iterate: Iterate) -> csr_array:
    """Differentiate the distances from point to point by the unknowns of a step. Shape (k - 1, 5 n + 2).

    The last results are kept: constraints, objective and its curvature ask for the same ones.
    """
    return _chord_rows(points, iterate, _unit_chords(iterate)[:, None])


def chord_curvature(points: EvaluationPoints, iterate: Iterate, weights: FloatArray) -> csr_array:
    """Differentiate weights (k - 1,) . distances twice, the moves taken as linear: sum of w/d |across|^2. Square."""
    unit = _unit_chords(iterate)
    across = np.eye(len(CONTROLLED)) - unit[:, :, None] * unit[:, None]
    scale = np.sqrt(weights / np.maximum(iterate.distances, _NO_DISTANCE))
    rows = _chord_rows(points, iterate, scale[:, None, None] * across)
    return csr_array(rows.T @ rows)


def _unit_chords(iterate: Iterate) -> FloatArray:
    return np.asarray(iterate.chords / np.maximum(iterate.distances, _NO_DISTANCE)[:, None], dtype=float)


def _chord_rows(points: EvaluationPoints, iterate: Iterate, axes: FloatArray) -> csr_array:
    """Differentiate the chords, in steps of the route, along `axes` (k - 1, m, 5). Shape (m (k - 1), 5 n + 2)."""
    by_q = iterate.moves[:, CONTROLLED] / points.steps[:, None]
    here = np.repeat(np.arange(len(axes)), axes.shape[1])
    begin, end = ((axes @ part).reshape(-1, 5) for part in (by_q[:-1], by_q[1:]))
    return csr_array(by_unknowns(points, here + 1, end) - by_unknowns(points, here, begin))


def _scaled(factor: FloatArray, rows: csr_array) -> csr_array:
    return csr_array(diags_array(factor) @ rows)


def _less_length(by_chord: csr_array, factor: FloatArray) -> csr_array:
    """Subtract `factor` (m,) times the length, the last unknown, from rows (m, 5 n + 2)."""
    width = by_chord.shape[1]
    return csr_array(by_chord - hstack([csr_array((len(factor), width - 1)), csr_array(factor[:, None])]))


def _length_balance(points: EvaluationPoints, iterate: Iterate) -> csr_array:
    """Write that the length changes by as much as all distances together."""
    return _less_length(csr_array(chord_slopes(points, iterate).sum(axis=0)[None]), np.ones(1))


def _speed_range(points: EvaluationPoints, iterate: Iterate) -> Constraint:
    """Keep distances less a share of length * ds, in units of length * ds: not below zero, then not above."""
    distances, ds = iterate.distances, np.diff(points.s)
    factor, scale = np.repeat(SPEED_RANGE, len(ds)), np.tile(float(distances.sum()) * ds, 2)
    relative = np.tile(distances, 2) / scale
    low = np.where(factor == SPEED_RANGE[0], 0.0, -np.inf)
    high = np.where(factor == SPEED_RANGE[1], 0.0, np.inf)

    def slope(rows: IntArray) -> csr_array:
        by_chord = chord_slopes(points, iterate)
        by_step = _less_length(by_chord[rows % len(ds)], (relative * np.tile(ds, 2))[rows])
        return _scaled(1.0 / scale[rows], by_step)

    return Constraint(relative - factor, low, high, _SPEED_SLACK, slope)


def _ends(points: EvaluationPoints, directions: FloatArray, iterate: Iterate) -> Iterator[Constraint]:
    """Keep the least speed of the actuators at both ends, and the directions in which they leave and arrive."""
    t, c, q, s = points.knots, iterate.coefficients, iterate.samples.q_m, points.s
    means = ((q[1] - q[0]) / (s[1] - s[0]), (q[-1] - q[-2]) / (s[-1] - s[-2]))
    leg_speeds = (DEGREE / (t[DEGREE + 1] - t[0]), DEGREE / (t[-1] - t[-DEGREE - 2]))
    travelled = float(np.linalg.norm(np.diff(q, axis=0), axis=1).sum())
    for first, direction, mean, leg_speed in zip((0, len(c) - 2), directions, means, leg_speeds, strict=True):
        leg = c[first + 1] - c[first]
        least = max(END_SPEED * float(np.linalg.norm(mean)), _LEAST_END_SPEED * travelled) / leg_speed
        given = bool(np.isfinite(direction).all())
        along = direction if given else leg / max(float(np.linalg.norm(leg)), 1e-12)
        yield _leg(along[None], first, c, (least, np.inf), max(0.1 * least, _EXACT))
        if given:
            yield _leg(null_space(direction[None]).T, first, c, (0.0, 0.0), _EXACT)


def one_way_constraint(one_way: Sequence[OneWayLeg], iterate: Iterate) -> Constraint:
    """Keep legs of the control polygon from going the way that is blocked to their actuators."""
    c = iterate.coefficients
    legs, actuators, signs = (np.array(column) for column in zip(*one_way, strict=True))
    rows, first = np.arange(len(legs)), 5 * legs + actuators
    entries = (np.concatenate([signs, -signs]), (np.tile(rows, 2), np.concatenate([first, first + 5])))
    slope = csr_array(entries, shape=(len(legs), c.size + 2))
    value = -signs * (c[legs + 1, actuators] - c[legs, actuators])
    zero = np.zeros(len(legs))
    return Constraint(value, zero, np.full(len(legs), np.inf), _ONE_WAY_SLACK_M, lambda at: csr_array(slope[at]))


def _leg(axes: FloatArray, first: int, c: FloatArray, bounds: tuple[float, float], slack: float) -> Constraint:
    """Bound the components along axes (m, 5) of the leg of the control polygon from coefficient `first` on."""
    slope = np.zeros((len(axes), 5 * len(c) + 2))
    slope[:, 5 * first : 5 * first + 10] = np.hstack([-axes, axes])
    low, high = (np.full(len(axes), bound) for bound in bounds)
    return Constraint(axes @ (c[first + 1] - c[first]), low, high, slack, lambda rows: csr_array(slope[rows]))
