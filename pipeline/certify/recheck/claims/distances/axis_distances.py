"""The least distances between axes: of links that share no joint, and of links and other arms' rails if required."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.calibrated.closures import row_norms
from pipeline.certify.recheck.arithmetic.calibrated.displacement import Displacement
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    dot,
    exactly,
    root,
    rounded_down,
    times,
    total,
    within,
)
from pipeline.certify.recheck.arithmetic.erring import Erring, joint_moves
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, power
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import norm
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.inclusion.distances.axes import AxisPairs, joint_rates, separating_directions, turning_rates
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
    off = segment.displacement(machine), segment.erring(machine)
    distances = [
        distance_bounds(machine, AxisPairs.of(pairs, from_rail, machine), segment.boxes, off)
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


def required_m(machine: Machine) -> FloatArray:
    """Return the required distance of every pair that the machine has."""
    return np.concatenate([np.empty(0), *(np.full(len(pairs), least) for pairs, _, least in _groups(machine))])


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
    required = required_m(evidence.machine)
    kept = (least >= stated.distances_m) & (stated.distances_m >= required)
    shown = int(np.argmin(least - required) if kept.all() else np.argmin(kept))
    yield Claim(
        DISTANCES,
        bool(kept.all()),
        f"{names[shown]} {least[shown]:.6g} m, stated {stated.distances_m[shown]:.6g}, required {required[shown]:g}",
    )


def distance_bounds(
    machine: Machine, pairs: AxisPairs, boxes: Boxes, off: tuple[Displacement, Erring | None]
) -> FloatArray:
    """Bound the distances of pairs from below, for joints displaced from those along the cubics. Shape (pairs, n).

    With errors of the actuators, for all of them: the joints are then displaced from those along the cubics and P a.
    A bound holds for any direction, so that the directions may be those of the search: they need not be right.
    """
    h, (displacement, errors) = boxes.half, off
    points = [_end_points(machine, motion, order) for motion, order in ((boxes.at, 0), (boxes.at, 1), (boxes.over, 2))]
    n = _directions(pairs, points, h)
    size = np.maximum(*(norm(np.moveaxis((n[0] + n[1] * exactly(t)).magnitude, 1, 0)) for t in (-h, h)))
    turning = None if errors is None else _turning(pairs, boxes, points, n[0] + n[1] * within(h), errors)
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
            parts = [times(term.magnitude, power(h, k)) for k, term in enumerate(series[1:], start=1)]
            if turning is not None:
                parts.append(turning.closer(p, q))
            if displacement.moves is not None:
                parts.append(_closer(n[0] + n[1] * within(h), displacement.moves[p] - displacement.moves[q]))
            least = np.minimum(least, (series[0] - exactly(total(*parts))).lower)
    size = size if turning is None else turning.size(size)
    shifts = displacement.rest
    # No point between two ends moves farther than the end that moves farther.
    moved_by = total(*(np.maximum(shifts[of[:, 0]], shifts[of[:, 1]]) for of in (pairs.first, pairs.second)))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(least > 0.0, rounded_down(least / size, 1), 0.0)
        distance = np.where(size > 0.0, share - moved_by, 0.0)
    return np.maximum(np.nextafter(distance, -np.inf), 0.0)


def _closer(n: Enclosure, apart: Enclosure) -> FloatArray:
    """Bound |n' M| for directions (pairs, 3, n) and M (pairs, 3, m, n), (pairs, n)."""
    return row_norms(contract("pcn,pcmn->pmn", n, apart, 3))


@dataclass(frozen=True, eq=False)
class _Turning:
    """Directions n + sum a_k M_k that turn with the errors a: n over intervals (pairs, 3, n), M (pairs, 3, 5, n).

    `points` (15, 3, n) are end points over the intervals, `moves` (15, 3, 5, n) their derivatives by errors (5, n).
    """

    n: Enclosure
    rates: Enclosure
    points: Enclosure
    moves: Enclosure
    errors: FloatArray

    def closer(self, p: IntArray, q: IntArray) -> FloatArray:
        """Bound by how much n . (P - Q) of end points becomes smaller with the errors, (pairs, n)."""
        S, D = self.moves[p] - self.moves[q], self.points[p] - self.points[q]
        first = contract("pcn,pcan->pan", self.n, S, 3) + contract("pcan,pcn->pan", self.rates, D, 3)
        linear = bound("pan,an->pn", first.magnitude, self.errors, terms=5)
        return total(linear, times(self._turned(), bound("pan,an->pn", _lengths(S), self.errors, terms=5)))

    def size(self, before: FloatArray) -> FloatArray:
        """Bound |n| for all errors, (pairs, n), where it is `before` without them."""
        along = contract("pcn,pcan->pan", self.n, self.rates, 3).magnitude
        turned = self._turned()
        return root(
            total(times(before, before), 2.0 * bound("pan,an->pn", along, self.errors, terms=5), times(turned, turned))
        )

    def _turned(self) -> FloatArray:
        return bound("pan,an->pn", _lengths(self.rates), self.errors, terms=5)


def _lengths(vectors: Enclosure) -> FloatArray:
    """Bound the lengths of vectors (pairs, 3, 5, n), shape (pairs, 5, n)."""
    return norm(np.moveaxis(vectors.magnitude, 1, 0))


def _turning(pairs: AxisPairs, boxes: Boxes, points: list[Enclosure], n: Enclosure, errors: Erring) -> _Turning:
    """Let directions follow the closest points; they need not be right."""
    axes, arms, P, middle = (
        np.moveaxis(part, -1, 0) for part in (boxes.at.axes[0].mid, boxes.at.arms[0].mid, errors.matrix, points[0].mid)
    )
    rates = turning_rates(pairs, middle, joint_rates(axes, arms, P, boxes.at.rails))
    h = boxes.half
    everywhere = points[0] + points[1] * within(h) + points[2] * within(power(h, 2))
    normal_rates = _across(pairs, exactly(rates.transpose(2, 3, 0, 1)))
    return _Turning(n, normal_rates, everywhere, joint_moves(errors), errors.errors)


def _directions(pairs: AxisPairs, points: list[Enclosure], h: FloatArray) -> list[Enclosure]:
    """Choose directions n0 + n1 t from those at both ends of each box. Two of shape (pairs, 3, n)."""
    ends = [points[0].mid + t * points[1].mid + t * t * points[2].mid for t in (-h, h)]
    before, after = (separating_directions(pairs, np.moveaxis(end, -1, 0)) for end in ends)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(h[:, None, None] > 0.0, (after - before) / (2.0 * h[:, None, None]), 0.0)
    return [_across(pairs, exactly(np.moveaxis(part, 0, -1))) for part in ((before + after) / 2.0, slope)]


def _across(pairs: AxisPairs, directions: Enclosure) -> Enclosure:
    """Make directions (pairs, 3, ...) normal to the rails exactly, by their x: n_x d_x = -(n_y d_y + n_z d_z)."""
    if not pairs.from_rail:
        return directions
    mid, rad = directions.mid.copy(), directions.rad.copy()
    each = (-1, *[1] * (mid.ndim - 2))
    x, y, z = (exactly(column.reshape(each)) for column in pairs.along.T)
    along = -(directions[:, 1] * y + directions[:, 2] * z) * x.inverse()
    mid[:, 0], rad[:, 0] = along.mid, along.rad
    return Enclosure(mid, rad)


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
