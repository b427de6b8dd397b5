"""Whether boxes hold no pose within the limits with kappa <= K and the start's sign of det H."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.bound.recheck.kappa import excluded, linear
from pipeline.bound.recheck.poses import Assembled, Posed, Vector, assemble, pose, square, statics
from pipeline.bound.recheck.taylor import Taylor
from pipeline.certify.recheck.arithmetic.enclosure import exactly
from pipeline.machine.clearance import link_pairs
from pipeline.machine.geometry import TELESCOPES, Machine

_BATCH = 512
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
        good = np.concatenate(
            [np.zeros(0, dtype=bool)]
            + [_verified(claim, low[:, k : k + _BATCH], high[:, k : k + _BATCH]) for k in range(0, len(owner), _BATCH)]
        )
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
    at = pose(machine, *_middle_half(low[:, rest], high[:, rest]))
    found = assemble(machine, at)
    out = _outside(machine, found) | _too_close(machine, at, found)
    columns, ties = linear(statics(machine, at, found)), linear([found.mismatch])
    done[rest] = out | excluded(columns, ties, claim.sign, claim.kappa)
    return done


def _middle_half(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cover boxes: bounds of the lattice are rounded, but those that are fixed are exact."""
    half = np.where(low == high, 0.0, 0.5 * (high - low) * (1.0 + 1e-14) + 1e-14)
    return 0.5 * (low + high), half


def _within_reach(low: FloatArray, high: FloatArray, D: list[Taylor]) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Narrow s_k to s_k^2 = D_k; tell where nothing is left."""
    low, high = low.copy(), high.copy()
    empty = np.zeros(low.shape[1], dtype=bool)
    for k, form in enumerate(D, start=4):
        least, largest = form.range
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
    out = np.zeros(found.carts[0].half.shape[1], dtype=bool)
    for tie in found.mismatch:
        low, high = tie.range
        out |= (low > 0.0) | (high < 0.0)
    first, second = found.carts
    for form, i, j in ((first, 0, 2), (second, 1, 2), (first - second, 0, 1)):
        low, high = form.range
        out |= (high < travel[i, 0] - travel[j, 1] - 1e-12) | (low > travel[i, 1] - travel[j, 0] + 1e-12)
    for link, (shortest, longest) in zip(TELESCOPES.tolist(), machine.strokes_m.tolist(), strict=True):
        low, high = square(found.vectors[link]).range
        out |= (high < shortest**2 - 1e-12) | (low > longest**2 + 1e-12)
    return out


def _too_close(machine: Machine, at: Posed, found: Assembled) -> BoolArray:
    """Find boxes in which two points of two links, followed to first order, stay nearer than allowed."""
    close = np.zeros(at.half.shape[1], dtype=bool)
    if not machine.link_link_m > 0.0:
        return close
    for i, j in link_pairs(machine):
        apart = [a - b for a, b in zip(at.joints[i], at.joints[j], strict=True)]
        for points in _followed(apart, found.vectors[i], found.vectors[j]):
            squared = sum(form.largest**2 for form in points)
            close |= np.sqrt(squared) < machine.link_link_m - 1e-9
    return close


def _followed(apart: Vector, a: Vector, b: Vector) -> list[Vector]:
    """Give apart - s a + t b for the s and t in [0, 1] that are nearest at the middle, fixed and followed."""
    w, u, v = (np.stack([form.value.mid for form in vector], axis=1) for vector in (apart, a, b))
    M = np.stack([np.stack([-u, v], axis=2)], axis=0)[0]
    gram = M.transpose(0, 2, 1) @ M + 1e-12 * np.eye(2)
    st = np.clip(-np.linalg.solve(gram, M.transpose(0, 2, 1) @ w[..., None])[..., 0], 0.0, 1.0)
    for k in (0, 1):
        st[:, k] = np.clip(st[:, k] - _along(M[:, :, k], w + (M @ st[..., None])[..., 0]), 0.0, 1.0)
    slopes = [np.stack([form.slope.mid for form in vector], axis=2) for vector in (apart, a, b)]
    moved = slopes[0] - st[:, 0, None] * slopes[1] + st[:, 1, None] * slopes[2]
    by = -np.linalg.solve(gram[None], M.transpose(0, 2, 1)[None] @ moved[..., None])[..., 0]
    half = apart[0].half
    reach = (np.abs(by) * half[..., None]).sum(axis=0)
    fits = (st - reach > 1e-12) & (st + reach < 1.0 - 1e-12)
    choices = []
    for slope in (np.zeros_like(by), by * fits):
        s, t = (
            Taylor(exactly(st[:, k].copy()), exactly(slope[..., k].copy()), np.zeros((6, 6, len(st))), half)
            for k in (0, 1)
        )
        choices.append([p - s * x + t * y for p, x, y in zip(apart, a, b, strict=True)])
    return choices


def _along(direction: FloatArray, rest: FloatArray) -> FloatArray:
    return np.asarray((direction * rest).sum(axis=1) / (direction**2).sum(axis=1))
