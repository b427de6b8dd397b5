"""The boxes of controlled poses to avoid, if there are any."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import exactly, total
from pipeline.certify.recheck.arithmetic.ranges import part_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.limits.avoid import PROOF_ROUNDING, PROOF_SLACK, boxes_to_avoid
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import CONTROLLED

OUTSIDE = "the motion stays out of all boxes to avoid"
CLAIMS: tuple[str, ...] = (OUTSIDE,)
KEYS: tuple[str, ...] = ("avoided_by",)
LEAST = -(PROOF_ROUNDING + PROOF_SLACK)
"""Least bound with which a box counts as avoided: its surface may be touched."""

_PARTS = 128
"""Parts of an interval: as fine as the search ever divides it, so that no bound here is below one of its own."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound how far outside every box the poses are over some boxes of the chain, for all errors of the actuators.

    In every part of an interval the side counts that the pose is farthest beyond.
    """
    avoided = boxes_to_avoid(config)
    if not avoided:
        return np.empty((0, 2))
    following, off = segment.inclusions.following, segment.displacement(machine).pose
    if following is not None:
        off = total(off, following.moved)
    reach = exactly(off[CONTROLLED])
    poses, least = exactly(segment.boxes.pose[:, CONTROLLED]), np.full(len(avoided), np.inf)
    for low, high in part_ranges(poses, segment.boxes.half, _PARTS):
        lowest, highest = (exactly(low) - reach).lower, (exactly(high) + reach).upper
        for k, box in enumerate(avoided):
            below = (exactly(box.low[:, None]) - exactly(highest)).lower
            above = (exactly(lowest) - exactly(box.high[:, None])).lower
            sides = np.where(np.isfinite(np.stack([box.low, box.high]))[..., None], [below, above], -np.inf)
            least[k] = np.minimum(least[k], sides.max(axis=(0, 1)).min())
    return lower_bounds(least)


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify how far outside every box the motion is for every s."""
    boxes, ranges = len(evidence.config.task.avoid), stated.ranges.get(KEYS[0])
    if not boxes:
        yield Claim(OUTSIDE, verified=ranges is None, found="there are none")
        return
    names = tuple(f"task.avoid[{k}]" for k in range(boxes))
    if ranges is None or ranges.subjects != names:
        yield Claim(OUTSIDE, verified=False, found="not stated" if ranges is None else "other boxes are stated")
        return
    least, proven = evidence.least, ranges.values[:, 0]
    kept = (least >= proven) & (proven >= LEAST)
    shown = int(np.argmin(least) if kept.all() else np.argmin(kept))
    found = f"{names[shown]} by {least[shown]:.6g} m or rad, stated {proven[shown]:.6g}"
    yield Claim(OUTSIDE, bool(kept.all()), found)
