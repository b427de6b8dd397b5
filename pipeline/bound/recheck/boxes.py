"""Whether boxes hold no pose within the limits with kappa <= K and the start's sign of det H."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.recheck.kappa import excluded
from pipeline.bound.recheck.poses import Assembled, Posed, assemble, pose, statics
from pipeline.bound.recheck.taylor import Taylor, linear
from pipeline.machine.clearance import link_pairs
from pipeline.machine.geometry import Machine
from pipeline.parallel import blocks, in_parallel

_BATCH = 1024
_DEEPEST = 14
"""How often a box that is not verified as a whole is halved."""
_SHRINKING = 6
"""Halvings after which what is left has to become less by each: else it is false."""
_MOST_PARTS = 3
"""Parts for each box at which verification is given up: a true proof needs fewer."""


@dataclass(frozen=True)
class Claim:
    """What is claimed of boxes of a machine: kappa > K or not this sign of det H."""

    machine: Machine
    sign: float
    kappa: float


def verified(claim: Claim, low: FloatArray, high: FloatArray) -> BoolArray:
    """Verify boxes (6, n), halved where needed. Shape (n,)."""
    result = np.ones(low.shape[1], dtype=bool)
    owner = np.arange(low.shape[1])
    left = len(owner)
    for depth in range(_DEEPEST + 1):
        parts = [partial(_verified, claim, low[:, rows], high[:, rows]) for rows in blocks(len(owner), _BATCH)]
        good = np.concatenate([np.zeros(0, dtype=bool), *in_parallel(parts)])
        low, high, owner = low[:, ~good], high[:, ~good], owner[~good]
        hopeless = len(owner) > _MOST_PARTS * len(result) + _BATCH or (depth > _SHRINKING and len(owner) >= left)
        if not owner.size or depth == _DEEPEST or hopeless:
            break
        left = len(owner)
        axis, rows = (high - low).argmax(axis=0), np.arange(len(owner))
        middle = 0.5 * (low[axis, rows] + high[axis, rows])
        lower, upper = high.copy(), low.copy()
        lower[axis, rows], upper[axis, rows] = middle, middle
        low, high = np.concatenate([low, upper], axis=1), np.concatenate([lower, high], axis=1)
        owner = np.concatenate([owner, owner])
    result[owner] = False
    return result


def _verified(claim: Claim, low: FloatArray, high: FloatArray) -> BoolArray:
    machine = claim.machine
    done = np.zeros(low.shape[1], dtype=bool)
    at = pose(machine, *_middle_half(low, high))
    low, high, empty = _within_reach(low, high, at.D)
    done |= empty
    rest = np.flatnonzero(~done)
    if not rest.size:
        return done
    at = at.at(rest)
    found = assemble(machine, at, *_middle_half(low[:, rest], high[:, rest]))
    out = _outside(machine, found)
    out |= _too_close(machine, at, found)
    done[rest] = out | excluded(statics(machine, at, found), found.ties, claim.sign, claim.kappa)
    return done


def _middle_half(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cover boxes: bounds of the lattice are rounded, but those that are fixed are exact."""
    half = np.where(low == high, 0.0, 0.5 * (high - low) * (1.0 + 1e-14) + 1e-14)
    return 0.5 * (low + high), half


def _within_reach(low: FloatArray, high: FloatArray, D: Taylor) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Narrow s_k to s_k^2 = D_k; tell where nothing is left."""
    low, high = low.copy(), high.copy()
    empty = np.zeros(low.shape[1], dtype=bool)
    for k, (least, largest) in enumerate(zip(*D.range, strict=True), start=4):
        outer, inner = np.sqrt(np.maximum(largest, 0.0)) + 1e-14, np.sqrt(np.maximum(least, 0.0)) - 1e-14
        low[k], high[k] = np.maximum(low[k], -outer), np.minimum(high[k], outer)
        low[k] = np.where((low[k] > -inner) & (inner > 0.0), np.maximum(low[k], inner), low[k])
        high[k] = np.where((high[k] < inner) & (inner > 0.0), np.minimum(high[k], -inner), high[k])
        empty |= (largest < 0.0) | (low[k] > high[k])
    high[4:] = np.maximum(low[4:], high[4:])
    return low, high, empty


def _outside(machine: Machine, found: Assembled) -> BoolArray:
    """Find boxes that no cart position or stroke fits, or on which s_k^2 = D_k has no solution."""
    travel = machine.travel_m
    least, largest = found.ties.range
    out = ((least > 0.0) | (largest < 0.0)).any(axis=0)
    for form, i, j in ((found.carts[0], 0, 2), (found.carts[1], 1, 2), (found.carts[0] - found.carts[1], 0, 1)):
        least, largest = form.range
        out |= (largest < travel[i, 0] - travel[j, 1] - 1e-12) | (least > travel[i, 1] - travel[j, 0] + 1e-12)
    least, largest = found.squares.range
    strokes = machine.strokes_m**2
    out |= ((largest < strokes[:, :1] - 1e-12) | (least > strokes[:, 1:] + 1e-12)).any(axis=0)
    return np.asarray(out)


def _too_close(machine: Machine, at: Posed, found: Assembled) -> BoolArray:
    """Find boxes in which two points of two links, followed to first order, stay nearer than allowed."""
    close = np.zeros(found.ties.value.shape[1], dtype=bool)
    if not machine.link_link_m > 0.0:
        return close
    for i, j in link_pairs(machine):
        s, t, distance = _nearest(
            *(part.value for part in (at.arms[i] - at.arms[j], found.vectors[i], found.vectors[j]))
        )
        some = np.flatnonzero(~close & (distance < machine.link_link_m))
        if not some.size:
            continue
        apart = (at.arms[i] - at.arms[j]).at(some)
        for points in _followed(apart, found.vectors[i].at(some), found.vectors[j].at(some), np.stack([s, t])[:, some]):
            close[some] |= np.sqrt((points.largest**2).sum(axis=0)) < machine.link_link_m - 1e-9
    return close


def _nearest(w: FloatArray, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find s, t in [0, 1] at which w - s u + t v (3, n) is nearest to zero, by turns, and its length."""
    s, t = np.full(w.shape[1], 0.5), np.full(w.shape[1], 0.5)
    uu, vv, uv = (u * u).sum(axis=0), (v * v).sum(axis=0), (u * v).sum(axis=0)
    wu, wv = (w * u).sum(axis=0), (w * v).sum(axis=0)
    det = uu * vv - uv**2
    s = np.where(det > 1e-9, np.clip((wu * vv - uv * wv) / np.where(det > 1e-9, det, 1.0), 0.0, 1.0), s)
    for _ in range(2):
        t = np.clip((s * uv - wv) / vv, 0.0, 1.0)
        s = np.clip((wu + t * uv) / uu, 0.0, 1.0)
    return s, t, np.sqrt(((w - s * u + t * v) ** 2).sum(axis=0))


def _followed(apart: Taylor, a: Taylor, b: Taylor, st: FloatArray) -> list[Taylor]:
    """Give apart - s a + t b (3, n), s and t (2, n) in [0, 1] fixed, and following the box to first order."""
    M = np.stack([-a.value, b.value], axis=0).transpose(2, 1, 0)
    gram = M.transpose(0, 2, 1) @ M + 1e-12 * np.eye(2)
    moved = apart.slope - st[0] * a.slope + st[1] * b.slope
    by = -np.linalg.solve(gram, M.transpose(0, 2, 1) @ moved.transpose(2, 1, 0))
    by = by.transpose(1, 2, 0)
    reach = np.abs(by).sum(axis=1)
    by = by * ((st - reach > 1e-12) & (st + reach < 1.0 - 1e-12))[:, None]
    choices = []
    for slope in (np.zeros_like(by), by):
        s, t = (linear(st[k], slope[k]).expanded() for k in (0, 1))
        choices.append(apart - s * a + t * b)
    return choices
