"""The least distances between axes: of links that share no joint, and of links and other arms' rails if required."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, dot, exactly, rounded_down, times, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, power
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import joint_shift, norm
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.inclusion.distances.axes import AxisPairs, separating_directions
from pipeline.limits.axis_distance import pair_names
from pipeline.machine.clearance import link_pairs, rail_pairs
from pipeline.machine.geometry import Machine

DISTANCES = "axes keep their required distances"
CLAIMS: tuple[str, ...] = (DISTANCES,)
KEYS: tuple[str, ...] = ("distance_m",)


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the distances of all pairs that the machine has over some boxes; none where none is asked for."""
    if not _groups(machine):
        return np.empty((0, 2))
    distances = [
        distance_bounds(
            machine, AxisPairs.of(pairs, from_rail, machine.rails_m), segment.boxes, segment.inclusions.image
        )
        for pairs, from_rail, _ in _groups(machine)
    ]
    return lower_bounds(np.concatenate(distances).min(axis=1))


def _groups(machine: Machine) -> list[tuple[list[tuple[int, int]], bool, float]]:
    """List pairs of links, and of links and rails if they are asked for, with the distance that is required."""
    groups = [
        (link_pairs(machine), False, machine.link_link_m),
        (rail_pairs(machine), True, machine.link_rail_m),
    ]
    return [group for group in groups if np.isfinite(group[2])]


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the distances of all pairs that the machine has for every s."""
    groups, least = _groups(evidence.machine), evidence.least
    if not groups:
        yield Claim(DISTANCES, verified=KEYS[0] not in stated.ranges, found="distances of axes are not limited")
        return
    names = tuple(name for pairs, from_rail, _ in groups for name in pair_names(pairs, from_rail))
    if names != stated.pairs:
        missing = [name for name in names if name not in stated.pairs]
        yield Claim(DISTANCES, verified=False, found=f"other pairs are stated; missing: {', '.join(missing) or 'none'}")
        return
    required = np.concatenate([np.full(len(pairs), least) for pairs, _, least in groups])
    kept = (least >= stated.distances_m) & (stated.distances_m >= required)
    shown = int(np.argmin(least - required) if kept.all() else np.argmin(kept))
    yield Claim(
        DISTANCES,
        bool(kept.all()),
        f"{names[shown]} {least[shown]:.6g} m, stated {stated.distances_m[shown]:.6g}, required {required[shown]:g}",
    )


def distance_bounds(machine: Machine, pairs: AxisPairs, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound the distances of pairs from below, for poses within `deviation` (6, n) of the cubics. Shape (pairs, n).

    A bound holds for any direction, so that the directions may be those of the search: they need not be right.
    """
    h = boxes.half
    points = [_end_points(machine, motion, order) for motion, order in ((boxes.at, 0), (boxes.at, 1), (boxes.over, 2))]
    n = _directions(pairs, points, h)
    size = np.maximum(*(norm(np.moveaxis((n[0] + n[1] * exactly(t)).magnitude, 1, 0)) for t in (-h, h)))
    least = np.full((len(pairs.first), len(h)), np.inf)
    for p in pairs.first.T:
        for q in pairs.second.T:
            gap = [x[p] - x[q] for x in points]
            series = [
                dot(n[0], gap[0], 1),
                dot(n[0], gap[1], 1) + dot(n[1], gap[0], 1),
                dot(n[0], gap[2], 1) + dot(n[1], gap[1], 1),
                dot(n[1], gap[2], 1),
            ]
            spread = total(*(times(term.magnitude, power(h, k)) for k, term in enumerate(series[1:], start=1)))
            least = np.minimum(least, (series[0] - exactly(spread)).lower)
    shift = joint_shift(machine, deviation)
    off = np.concatenate([np.zeros_like(shift), shift, np.zeros((3, len(h)))])
    moved_by = total(*(off[of[:, end]] for of in (pairs.first, pairs.second) for end in (0, 1)))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(least > 0.0, rounded_down(least / size, 1), 0.0)
        distance = np.where(size > 0.0, share - moved_by, 0.0)
    return np.maximum(np.nextafter(distance, -np.inf), 0.0)


def _directions(pairs: AxisPairs, points: list[Enclosure], h: FloatArray) -> list[Enclosure]:
    """Choose directions n0 + n1 t from those at both ends of each box. Two of shape (pairs, 3, n)."""
    ends = [points[0].mid + t * points[1].mid + t * t * points[2].mid for t in (-h, h)]
    before, after = (separating_directions(pairs, np.moveaxis(end, -1, 0)) for end in ends)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(h[:, None, None] > 0.0, (after - before) / (2.0 * h[:, None, None]), 0.0)
    return [exactly(np.moveaxis(part, 0, -1)) for part in ((before + after) / 2.0, slope)]


def _end_points(machine: Machine, motion: Motion, order: int) -> Enclosure:
    """Return the terms of one order of cart joints, platform joints and rails, (15, 3, n)."""
    tcp, arms, vectors = motion.pose[order][:3], motion.arms[order], motion.vectors[order]
    platform = Enclosure(tcp.mid[None], tcp.rad[None]) + arms
    carts = platform - vectors
    rails = np.zeros((3, 3, tcp.mid.shape[-1]))
    if order == 0:
        rails[:, 1:] = machine.rails_m[..., None]
    mid = np.concatenate([carts.mid, platform.mid, rails])
    return Enclosure(mid, np.concatenate([carts.rad, platform.rad, np.zeros_like(rails)]))
