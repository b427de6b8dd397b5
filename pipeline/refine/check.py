"""The check between the nodes: what the program promises at its nodes has to hold along the whole path.

Between two neighbouring samples a margin counts as kept if the smaller of both exceeds what the margin could fall in
between: half its second derivative times the squared distance, four times what a parabola needs. Elsewhere samples are
added until that is so.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError
from pipeline.refine.measure import PathSamples, merge_samples, sample_path
from pipeline.refine.mesh import midpoints
from pipeline.refine.requirements import Requirement, path_requirements
from pipeline.refine.result import Path
from pipeline.route.result import Route

_HALVINGS = 12
"""How often an interval between two samples is halved at most; a fall left then is below any tolerance."""


@dataclass(frozen=True, eq=False)
class Violation:
    """A broken requirement: what, by how much at worst, at which s (n,), and what to change."""

    what: str
    worst: float
    s: FloatArray
    advice: str

    def __str__(self) -> str:
        return f"{self.what} (by {self.worst:.4g} at worst, first at s = {self.s[0]:.4f})"


def find_violations(
    config: Config,
    route: Route,
    path: Path,
    coarse: Path,
    sample: Callable[[Path, FloatArray], PathSamples] = sample_path,
) -> list[Violation]:
    """List what a path breaks of its requirements, sampled as densely as it takes.

    Parameters
    ----------
    sample : callable
        Evaluates the path at s (n,).
    """
    return find_broken(path, path_requirements(config, route, path, coarse), config.refine.check_points, sample)


def find_broken(
    path: Path,
    required: list[Requirement],
    points: int,
    sample: Callable[[Path, FloatArray], PathSamples] = sample_path,
) -> list[Violation]:
    """List what a path breaks of some requirements, sampled at as many points at least, and as densely as it takes."""
    s = np.linspace(0.0, 1.0, points + 1)
    try:
        near = samples = sample(path, s)
        whole, added = np.ones(len(s) - 1, dtype=bool), []
        for _ in range(_HALVINGS):
            doubtful = _doubtful(required, near) & whole
            s = midpoints(near.s)[doubtful]
            if len(s) == 0:
                break
            added.append(sample(path, s))
            near, whole = _closer(near, whole, doubtful, added[-1])
    except ForwardKinematicsError as error:
        what = "the closure equations have no solution, links miss their lengths by metres"
        return [Violation(what, error.residual_m, s[[error.index]], "Raise refine.nodes.")]
    if added:
        samples = merge_samples(samples, reduce(merge_samples, added))
    found = []
    for requirement in required:
        broken = (requirement.margins(samples) < -requirement.rounding) & requirement.counts(samples)
        if broken.any():
            worst = float(requirement.excess(samples)[broken].max())
            found.append(Violation(requirement.what, worst, samples.s[broken.any(axis=1)], requirement.advice))
    return found


def _doubtful(required: list[Requirement], samples: PathSamples) -> BoolArray:
    """Find the intervals between n samples within which a requirement may be broken. Shape (n - 1,)."""
    doubtful = np.zeros(len(samples) - 1, dtype=bool)
    for requirement in required:
        if requirement.continuous:
            margins, counts = requirement.margins(samples), requirement.counts(samples)
            doubtful |= doubtful_intervals(samples.s, margins, requirement.rounding, counts)
    return doubtful


def _closer(
    samples: PathSamples, whole: BoolArray, doubtful: BoolArray, added: PathSamples
) -> tuple[PathSamples, BoolArray]:
    """Leave out the samples that are not beside a doubtful interval, and add those in the middle of each.

    Returns the samples, m of them, and which intervals between them are `whole` (m - 1,): nothing was left out there.
    """
    beside = np.flatnonzero(doubtful)[:, None] + np.array([-1, 0, 1, 2])
    kept = np.unique(np.clip(beside, 0, len(samples) - 1))
    unbroken = (np.diff(kept) == 1) & whole[kept[:-1]]
    left = samples.take(kept)
    merged = merge_samples(left, added)
    return merged, unbroken[np.searchsorted(left.s, midpoints(merged.s)) - 1]


def doubtful_intervals(s: FloatArray, margins: FloatArray, rounding: float, counts: BoolArray) -> BoolArray:
    """Find intervals of s (n,) in which a margin (n, m) that is kept at both ends may be broken. Shape (n - 1,).

    Margins that are infinite somewhere are left out, and those that count at neither end (`counts`, (n, m)).
    """
    finite = np.isfinite(margins).all(axis=0)
    step, margins, counts = np.diff(s)[:, None], margins[:, finite], np.broadcast_to(counts, margins.shape)[:, finite]
    slope = np.diff(margins, axis=0) / step
    bend = np.zeros_like(margins)
    bend[1:-1] = 2.0 * np.abs(np.diff(slope, axis=0)) / (step[1:] + step[:-1])
    bend[[0, -1]] = bend[[1, -2]]
    fall = np.maximum(bend[1:], bend[:-1]) * step**2 / 2.0
    least = np.minimum(margins[1:], margins[:-1])
    kept = (margins >= -rounding) | ~counts
    doubtful = kept[1:] & kept[:-1] & (least - fall < -rounding) & (counts[1:] | counts[:-1])
    return np.asarray(doubtful.any(axis=1), dtype=bool)
