"""Links and thin bodies that pass through each other within a step.

Signs that two neighbouring regions must not have opposite are bits of words, as those of `candidates.passing_codes`.

Thin are capsules and whatever is endless along X, whose axis counts. Where both closest points of two axes are inside
and near each other, the sign is that of their distance along the common perpendicular.
"""

from functools import partial

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.clearance import common_perpendicular
from pipeline.machine.geometry import Machine
from pipeline.machine.shapes.model import Bodies, FrameKind
from pipeline.parallel import blocks, in_parallel
from pipeline.route.regions.table import RegionTable

_SLACK = 0.05
"""How far beyond its ends the closest point still counts as inside an axis, in its lengths."""
_FAR_M = 0.25
"""Axes farther apart do not pass through each other within a step."""
_BLOCK = 8_192
"""Batch size in regions."""


def body_codes(machine: Machine, regions: RegionTable, bits: int) -> IntArray:
    """Signs of all pairs of a link and a thin body, `bits` of either sign in each word. Shape (words, n)."""
    bodies = machine.bodies
    pairs = [] if bodies is None else _passing_pairs(bodies)
    if bodies is None or not pairs:
        return np.empty((0, len(regions)), dtype=np.int64)
    tasks = [partial(_codes, machine, pairs, regions.take(block), bits) for block in blocks(len(regions), _BLOCK)]
    return np.concatenate(list(in_parallel(tasks)), axis=1)


def _passing_pairs(bodies: Bodies) -> list[tuple[int, int]]:
    """Pick the pairs of a link and an axis of another kind; pairs of links are those of `passing_codes`."""
    thin = [len(hull.points_m) == 2 or hull.endless for hull in bodies.hulls]
    links = [hull.kind == FrameKind.LINK for hull in bodies.hulls]
    return [(i, j) for i, j in bodies.pairs if thin[i] and thin[j] and links[i] != links[j]]


def _codes(machine: Machine, pairs: list[tuple[int, int]], regions: RegionTable, bits: int) -> IntArray:
    assert machine.bodies is not None
    hulls = machine.bodies.hulls
    frames = Frames.of(machine, regions.pose, regions.q_m[:, :3])
    axes = {k: _axis(frames.points(hulls[k]), endless=hulls[k].endless) for pair in pairs for k in pair}
    codes = np.zeros((-(-len(pairs) // bits), len(regions)), dtype=np.int64)
    for number, (i, j) in enumerate(pairs):
        signed, s, t = common_perpendicular(*axes[i], *axes[j])
        with np.errstate(invalid="ignore"):
            met = np.abs(signed) <= _FAR_M
            for place, hull in ((s, hulls[i]), (t, hulls[j])):
                met &= hull.endless | (np.abs(place - 0.5) <= 0.5 + _SLACK)
        word, bit = divmod(number, bits)
        codes[word] |= (met & (signed > 0.0)).astype(np.int64) << bit
        codes[word] |= (met & (signed < 0.0)).astype(np.int64) << (bit + bits)
    return codes


def _axis(points: FloatArray, *, endless: bool) -> tuple[FloatArray, FloatArray]:
    """Give the axis of a thin hull of points (k, 3, n): where it begins, and its vector, both (n, 3)."""
    if not endless:
        return points[0].T, (points[1] - points[0]).T
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return middle.T, np.broadcast_to([1.0, 0.0, 0.0], (points.shape[2], 3))
