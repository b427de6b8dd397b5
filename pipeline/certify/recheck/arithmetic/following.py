"""Errors of the actuators as symbols, evaluated again; the statement is that of `pipeline.inclusion.following`."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    cross,
    exactly,
    total,
    within,
)
from pipeline.certify.recheck.arithmetic.motion import Motion, along_rails
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, TELESCOPES

OF_CART = np.eye(len(ACTUATORS))[ARM_OF_LINK]
"""Which cart each link is on, (6, 5)."""
EXTENSIBLE = np.zeros_like(OF_CART)
EXTENSIBLE[TELESCOPES, 3 + np.arange(len(TELESCOPES))] = 1.0
"""Which telescope each link is, (6, 5)."""


@dataclass(frozen=True, eq=False)
class Following:
    """What errors add: P (2, 6, 5, n) and P over each interval, A (5, n), |P| A and |C (J P + V)| A (6, n)."""

    matrix: FloatArray
    over: Enclosure
    errors: FloatArray
    moved: FloatArray
    miss: FloatArray


@dataclass(frozen=True, eq=False)
class FollowingTerms:
    """What errors add to an image: to k (6, n), to Q (6, 6, n), and per calibration symbol to k (6, 6, n)."""

    image: FloatArray
    spread: FloatArray
    mixed: FloatArray


def follow_actuators(
    motions: tuple[Motion, Motion], inverse: FloatArray, J: list[Enclosure], h: FloatArray, errors_m: FloatArray
) -> Following:
    """Choose P for all boxes from the closures about their centres and over their intervals, C and J."""
    at, over = motions
    V = [_rates(at, 0), _rates(at, 1), _rates(over, 2)]
    V0, V1 = V[0].mid, V[1].mid
    P0 = -_plain(inverse[0], V0)
    P = np.stack([P0, -(_plain(inverse[0], V1) + _plain(inverse[1], V0))])
    P0_, P1_ = exactly(P[0]), exactly(P[1])
    missing = [
        _product(J[0], P0_) + V[0],
        _product(J[0], P1_) + _product(J[1], P0_) + V[1],
        _product(J[1], P1_) + _product(J[2], P0_) + V[2],
        _product(J[2], P1_),
    ]
    parts = []
    for k, C in enumerate(inverse):
        for n, term in enumerate(missing):
            share = bound("ian,an->in", _product(exactly(C), term).magnitude, errors_m, terms=5)
            for _ in range(n + k):
                share = total(share * h)
            parts.append(share)
    everywhere = P0_ + P1_ * within(h)
    return Following(
        P, everywhere, errors_m, bound("ian,an->in", everywhere.magnitude, errors_m, terms=5), total(*parts)
    )


def following_terms(following: Following, hull: Motion, C: Enclosure, G: Enclosure) -> FollowingTerms:
    """Bound what errors add to the image of every box, with C over its interval and G = C f'' over the box."""
    axes, arms = hull.axes[0], hull.arms[0]
    turned = cross(_at(axes, 0), _at(arms, 1), axis=2)
    along = along_rails(Enclosure(turned.mid.swapaxes(0, 1), turned.rad.swapaxes(0, 1)), hull.rails)
    slopes = Enclosure(
        np.zeros((6, 6, len(ACTUATORS), C.mid.shape[-1])), np.zeros((6, 6, len(ACTUATORS), C.mid.shape[-1]))
    )
    for link, arm in enumerate(ARM_OF_LINK.tolist()):
        slopes.mid[link, :3, arm] = -hull.rails[link][:, None]
        slopes.mid[link, 3:, arm] = -along.mid[:, link]
        slopes.rad[link, 3:, arm] = along.rad[:, link]
    K = contract("iln,lkan->ikan", C, slopes, 6)
    GP = contract("ikjn,jan->ikan", G, following.over, 6)
    bent = GP + K
    A = following.errors
    M = contract("kan,ikbn->iabn", following.over, GP * exactly(0.5) + K, 6)
    squares = contract("lc,lc->l", exactly(hull.rails), exactly(hull.rails), 3)
    halves = exactly(0.5 * OF_CART) * Enclosure(squares.mid[:, None], squares.rad[:, None]) - exactly(0.5 * EXTENSIBLE)
    diagonal = contract("iln,la->ian", C, halves, 6)
    unit = np.eye(len(ACTUATORS))[None, :, :, None]
    M = M + Enclosure(diagonal.mid[:, :, None] * unit, diagonal.rad[:, :, None] * unit)
    both = M + Enclosure(M.mid.swapaxes(1, 2), M.rad.swapaxes(1, 2))
    second = 0.5 * bound("ian,an->in", bound("iabn,bn->ian", both.magnitude, A, terms=5), A, terms=5)
    mixed = bound("ilan,an->iln", contract("kln,ikan->ilan", C, bent, 6).magnitude, A, terms=5)
    return FollowingTerms(total(following.miss, second), bound("ikan,an->ikn", bent.magnitude, A, terms=5), mixed)


def following_change(here: Following, s: Enclosure, there: FloatArray, errors_m: FloatArray) -> FloatArray:
    """Bound |P(s) - P'| A, with s (n,) from the centres of boxes, P' (6, 5, n), A (5, n). Shape (6, n)."""
    P = exactly(here.matrix[0]) + exactly(here.matrix[1]) * s
    return bound("ian,an->in", (P - exactly(there)).magnitude, errors_m, terms=5)


def _rates(motion: Motion, order: int) -> Enclosure:
    """Return the coefficient of an order of V = df/dq, (6, 5, n)."""
    along, lengths = along_rails(motion.vectors[order], motion.rails), motion.lengths[order]
    mid, rad = (
        OF_CART[..., None] * v[:, None] + EXTENSIBLE[..., None] * length[:, None]
        for v, length in ((along.mid, lengths.mid), (along.rad, lengths.rad))
    )
    return Enclosure(-mid, rad)


def _product(a: Enclosure, b: Enclosure) -> Enclosure:
    return contract("ijn,jan->ian", a, b, 6)


def _plain(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ijn,jan->ian", a, b), dtype=float)


def _at(values: Enclosure, axis: int) -> Enclosure:
    return Enclosure(np.expand_dims(values.mid, axis), np.expand_dims(values.rad, axis))
