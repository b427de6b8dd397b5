"""Points that are not where anything was: found by a fit that hardly feels them, and left out of the one that counts.

Cauchy's weights w = 1 / (1 + (e / 3 sigma)^2) per point, by iteratively reweighted least squares; then every point that
is less likely than one in a thousand measurements has is rejected, and all others are fitted with weight 1.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.data.seen import close_at
from pipeline.calibrate.identify import Identification, Problem, identify
from pipeline.calibrate.model.forward import positions
from pipeline.calibrate.model.model import Model

_SCALE = 3.0
_MEDIAN = 1.538
"""Median length of a vector of three normal deviates."""
_ROUNDS, _REFITS = 30, 5
_SETTLED = 1e-3
_UNLIKELY = 1e-3


def identify_robustly(problem: Problem) -> tuple[Identification, BoolArray]:
    """Identify without outliers; give them, too. Shape (n, reflectors)."""
    seen = problem.poses.is_seen
    found = identify(replace(problem, weights=_weights(problem, problem.model)))
    for _ in range(_ROUNDS):
        weights = _weights(problem, found.model)
        if np.abs(np.sqrt(weights) - np.sqrt(found.problem.weights))[seen].max(initial=0.0) < _SETTLED:
            break
        found = identify(replace(problem, weights=weights))
    most, rejected = most_deviations(int(seen.sum())), np.zeros_like(seen)
    for _ in range(_REFITS):
        before, rejected = rejected, seen & (_errors(problem, found.model) > most)
        found = identify(replace(problem, poses=problem.poses.without(rejected)))
        if (rejected == before).all():
            break
    return found, rejected


def most_deviations(count: int) -> float:
    """Distance, in deviations of noise, that one of so many points exceeds in one of a thousand measurements."""
    return float(np.sqrt(chi2.isf(_UNLIKELY / max(count, 1), 3)))


def _weights(problem: Problem, model: Model) -> FloatArray:
    """Weigh points by their errors; while most are far off, by errors against those of most."""
    errors = _errors(problem, model)
    scale = _SCALE * max(1.0, float(np.median(errors[problem.poses.is_seen])) / _MEDIAN)
    return np.asarray(1.0 / (1.0 + (errors / scale) ** 2))


def _errors(problem: Problem, model: Model) -> FloatArray:
    """Give the distances of points from where they are predicted, in deviations of noise; 0 where unseen. (n, r)."""
    closed = close_at(model, problem.poses, problem.guess)
    off = np.linalg.norm(problem.poses.seen_m - positions(model, closed), axis=2)
    return np.asarray(np.nan_to_num(off) / problem.noise_m)
