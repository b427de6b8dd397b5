"""The stated error of the tool, verified again: the statement is that of `pipeline.pose_error.box_bound`."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain, evaluate_chain
from pipeline.certify.recheck.arithmetic.enclosure import bound, root, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, include
from pipeline.certify.recheck.claims import chain
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.poses import pose_claim
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path

_TOOL = "tool"
POSITION, ROTATION = "the tool is off by no more than stated", "the tool is turned by no more than stated"
ERRORS = "the errors are those that were asked for"
INTERVALS = "what is stated is stated of its boxes' intervals"
_TABLE_ROUNDING = 1e-12
"""How far the table may round the ends of its intervals."""
_NARROWED = 1.5
_LEAST_RADIUS = 1e-9
_ROUNDING = 1e-13
"""Relative to the sum of all magnitudes: more than sums of a dozen products lose."""
_RX, _RY, _RZ = 0, 1, 2


@dataclass(frozen=True, eq=False)
class StatedError:
    """What a run states of its tool's error.

    Attributes
    ----------
    chain : ProvenChain
        The boxes.
    intervals : (n, 2)
        Where the table's rows begin and end, rounded to its decimals.
    position_m, rotation_rad : (n,)
        Bounds over each box.
    """

    chain: ProvenChain
    intervals: FloatArray
    position_m: FloatArray
    rotation_rad: FloatArray


def verify_pose_error(machine: Machine, path: Path, stated: StatedError, asked: Uncertainty) -> list[Claim]:
    """Verify that a chain closes for the errors that were asked for, and every bound over it."""
    proven, counted = stated.chain, chain.BoxCounts()
    known = proven.uncertainty == asked and len(stated.position_m) == len(stated.rotation_rad) == len(proven.boxes)
    claims = [Claim(f"{_TOOL}: {ERRORS}", known, f"over {len(proven.boxes)} boxes"), _interval_claim(stated)]
    found: list[tuple[FloatArray, FloatArray]] = []
    # NaN compares as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        try:
            for segment in evaluate_chain(machine, path, proven):
                counted += chain.count_boxes(segment)
                found.append(_bounds(machine, segment, proven.uncertainty))
        except (np.linalg.LinAlgError, ValueError, OverflowError):
            text = "some numbers are too large, or give matrices without an inverse"
            return [*claims, Claim(f"{_TOOL}: its boxes can be evaluated", verified=False, found=text)]
    claims += chain.chain_claims(_TOOL, proven, counted)
    poses = pose_claim(path, proven)
    claims.append(replace(poses, what=f"{_TOOL}: {poses.what}"))
    return [*claims, *_bound_claims(stated, *(np.concatenate(part) for part in zip(*found, strict=True)))]


def _interval_claim(stated: StatedError) -> Claim:
    """Verify that each row is about its box: bounds of one are not those of another."""
    intervals = np.array([(box.first, box.last) for box in stated.chain.boxes])
    same = stated.intervals.shape == intervals.shape
    near = (np.abs(stated.intervals - intervals) <= _TABLE_ROUNDING).all(axis=1) if same else np.zeros(0, dtype=bool)
    found = f"{int(near.sum())} of {len(intervals)}"
    if same and not near.all():
        found += f"; not row {int(np.argmin(near)) + 1}"
    return Claim(f"{_TOOL}: {INTERVALS}", same and bool(near.all()), found)


def _bound_claims(stated: StatedError, position: FloatArray, rotation: FloatArray) -> Iterator[Claim]:
    rows = ((POSITION, position, stated.position_m, "mm"), (ROTATION, rotation, stated.rotation_rad, "mrad"))
    for what, bounds, most, unit in rows:
        if bounds.shape != most.shape:
            yield Claim(f"{_TOOL}: {what}", verified=False, found=f"{len(bounds)} boxes; {len(most)} are stated")
            continue
        kept = bounds <= most
        text = f"{1e3 * bounds.max():.6g} {unit}; stated {1e3 * most.max(initial=0.0):.6g} {unit}"
        if not kept.all():
            row = int(np.argmin(kept))
            first, last = stated.intervals[row] if row < len(stated.intervals) else (np.nan, np.nan)
            text = (
                f"row {row + 1}, s = {first:.6g} to {last:.6g}: {1e3 * bounds[row]:.6g} {unit}; "
                f"stated {1e3 * most[row]:.6g} {unit} ({int((~kept).sum())} of {len(kept)} rows)"
            )
        yield Claim(f"{_TOOL}: {what}", bool(kept.all()), text)


def _bounds(machine: Machine, segment: EvaluatedChain, uncertainty: Uncertainty) -> tuple[FloatArray, FloatArray]:
    """Bound how far the tool is off and turned over the boxes of a segment, (n,) each; NaN where that is not proven."""
    boxes, found = segment.boxes, segment.inclusions
    rest = total(found.image, _nominal(machine, boxes))
    drives = np.tile(np.array(uncertainty.actuator_m)[:, None], boxes.half.shape)
    sizes = np.concatenate([found.residual_change, drives])
    P = np.zeros((2, 6, 5, *boxes.half.shape)) if found.following is None else found.following.matrix
    symbols = np.concatenate([found.inverse, P], axis=2)
    most = np.abs(symbols[0]) + np.abs(symbols[1]) * boxes.half
    lost = _ROUNDING * np.einsum("iln,ln->in", most, sizes)
    reach = total(bound("iln,ln->in", most, sizes, terms=11), lost, found.image)[3 + _RZ]
    rz = boxes.over.pose[0]
    sines = _sines(rz.mid[3 + _RZ], total(rz.rad[3 + _RZ], reach, np.full_like(reach, _ROUNDING)))
    position, rotation = np.zeros_like(boxes.half), np.zeros_like(boxes.half)
    for side in (-1.0, 1.0):
        linear = (symbols[0] + side * boxes.half * symbols[1]) * sizes
        for moved in _corners(linear):
            position = np.maximum(position, np.linalg.norm(moved[:3], axis=0))
            w = moved[3:]
            for sine in sines:
                rotation = np.maximum(rotation, (w**2).sum(axis=0) - 2.0 * w[_RX] * w[_RY] * sine)
    slack = _ROUNDING * (most[3:] ** 2).sum(axis=0).max(axis=0) * (sizes.sum(axis=0) ** 2)
    return (
        total(position, lost[:3].sum(axis=0) * 2.0, root((rest[:3] ** 2).sum(axis=0) * (1.0 + _ROUNDING))),
        total(root(rotation + slack), lost[3:].sum(axis=0) * 2.0, rest[3:].sum(axis=0) * (1.0 + _ROUNDING)),
    )


def _sines(middle: FloatArray, spread: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bound sin over middles (n,) and all that is within `spread` (n,) from below and above."""
    ends = np.sin(middle - spread), np.sin(middle + spread)

    def passes(angle: float) -> BoolArray:
        """Check whether the angle, or it and full turns, is within reach."""
        begins, last = ((middle + side * spread - angle) / (2.0 * np.pi) for side in (-1.0, 1.0))
        return np.asarray(np.floor(begins) != np.floor(last))

    least = np.where(passes(-np.pi / 2.0), -1.0, np.minimum(*ends) - _ROUNDING)
    return least, np.where(passes(np.pi / 2.0), 1.0, np.maximum(*ends) + _ROUNDING)


def _corners(linear: FloatArray) -> Iterator[FloatArray]:
    """Give the sums (6, n) of contributions (6, m, n) with every choice of signs but for opposites."""
    used = linear[:, np.abs(linear).max(axis=(0, 2)) > 0.0]
    if not used.shape[1]:
        return
    moved = used[:, 0]

    def chosen(column: int, so_far: FloatArray) -> Iterator[FloatArray]:
        if column == used.shape[1]:
            yield so_far
            return
        yield from chosen(column + 1, so_far + used[:, column])
        yield from chosen(column + 1, so_far - used[:, column])

    yield from chosen(1, moved)


def _nominal(machine: Machine, boxes: Boxes) -> FloatArray:
    """Bound how far the pose without errors is from x(t), (6, n); NaN where it is not proven to be in the box."""
    wide = include(machine, boxes, CERTAIN)
    radius = np.minimum(boxes.radius, _NARROWED * wide.image + _LEAST_RADIUS)
    narrow = include(machine, replace(boxes, radius=radius), CERTAIN)
    return np.where(wide.proven & narrow.proven, narrow.image, np.nan)
