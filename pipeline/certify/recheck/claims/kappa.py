"""The bound of kappa, and the sign of det H."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.calibrated.displacement import Displacement
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.determinant import det_signs
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    contract,
    exactly,
    root,
    rounded_down,
    times,
    total,
    within,
)
from pipeline.certify.recheck.arithmetic.erring import Erring, statics_derivatives
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, linear_inverse, power, residual_of_inverse
from pipeline.certify.recheck.arithmetic.motion import Motion
from pipeline.certify.recheck.arithmetic.norms import arm_lengths, frobenius, norm
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.config import Config
from pipeline.limits.kappa import path_cap
from pipeline.machine.geometry import Machine

KAPPA = "kappa stays below its bound, within the cap"
SIGN = "det H keeps its sign"
CLAIMS: tuple[str, ...] = (KAPPA, SIGN)
KEYS: tuple[str, ...] = ("kappa", "det_sign")


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound kappa and the sign of det H over some boxes."""
    kappa, sign = kappa_bounds(machine, segment.boxes, segment.displacement(machine), segment.erring(machine))
    return np.array([[-np.inf, kappa.max()], [sign.min(), sign.max()]])


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bound of kappa and the sign of det H for every s."""
    (_, worst), signs = evidence.found.tolist()
    cap = path_cap(evidence.config)
    yield Claim(
        KAPPA,
        worst <= stated.kappa <= cap,
        f"{worst:.6g}; stated {stated.kappa:.6g}, cap {cap:.6g}",
    )
    keeps = signs == [stated.det_sign] * 2 and stated.det_sign != 0
    yield Claim(SIGN, keeps, f"{', '.join(f'{one:+.0f}' for one in sorted(set(signs)))}; stated {stated.det_sign:+d}")


def kappa_bounds(
    machine: Machine, boxes: Boxes, displacement: Displacement, errors: Erring | None = None
) -> tuple[FloatArray, FloatArray]:
    """Bound kappa from above and find the sign of det H, each (n,), for joints displaced from those along the cubics.

    The sign is 0, and the bound infinite, if H may be singular. With errors, for all of them: the joints are then
    displaced from those along the cubics and P a.
    """
    at, over = boxes.at.statics(), boxes.over.statics()
    H = [at[0], at[1], over[2]]
    Y = [exactly(part) for part in linear_inverse(H)]
    h = boxes.half
    off = statics_change(machine, boxes.over if errors is None else errors.hull, displacement)
    by_H, by_YH = (np.zeros_like(h),) * 2 if errors is None else _changes(machine, errors, Y[0] + Y[1] * within(h))
    bound_Y = _largest(Y[0], Y[1], h)
    bound_H = total(_largest(H[0], H[1], h), times(power(h, 2), frobenius(H[2].magnitude)), off, by_H)
    miss = total(frobenius(residual_of_inverse(Y, H, h)), times(bound_Y, off), by_YH)
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.where(miss < 1.0, total(times(bound_H, bound_Y) / (1.0 - miss)), np.inf)
    # ||I - Y0 H'|| < 1: the determinants of Y0 and H have the same sign.
    return kappa, np.where(miss < 1.0, det_signs(Y[0].mid), 0.0)


def _changes(machine: Machine, errors: Erring, Y: Enclosure) -> tuple[FloatArray, FloatArray]:
    """Bound how much H' and Y H' change by all errors, (n,): norms of sums over corners, convex but for the radii."""
    scaled = statics_derivatives(machine, errors) * exactly(errors.errors[None, None])
    return _corners(scaled), _corners(contract("iln,lcan->ican", Y, scaled, 6))


def _corners(parts: Enclosure) -> FloatArray:
    """Bound ||sum e_a M_a||_2 over |e_a| <= 1, for M (6, 6, 5, n). Shape (n,)."""
    largest = np.zeros(parts.mid.shape[-1])
    for signs in product((1.0, -1.0), repeat=parts.mid.shape[2] - 1):
        summed = contract("ican,a->icn", parts, exactly(np.array([1.0, *signs])), 5)
        largest = np.maximum(largest, _norms(Enclosure(summed.mid, np.zeros_like(summed.rad))))
    # Radii of sums, and what these round, are the same in every corner.
    return total(largest, frobenius(total(summed.rad)))


def _largest(M0: Enclosure, M1: Enclosure, h: FloatArray) -> FloatArray:
    """Bound ||M0 + M1 t||_2 for |t| <= h, (n,): convex in t, so largest at an end."""
    return np.maximum(*(_norms(M0 + M1 * exactly(t)) for t in (-h, h)))


def _norms(M: Enclosure) -> FloatArray:
    """Bound ||M||_2, (n,), by nearly orthogonal singular vectors."""
    if not np.isfinite(M.mid).all():
        return np.full(M.mid.shape[-1], np.inf)
    V = np.linalg.svd(np.moveaxis(M.mid, -1, 0))[2].transpose(2, 1, 0)
    turned = contract("ijn,jkn->ikn", exactly(M.mid), exactly(V), 6)
    square = contract("jin,jkn->ikn", turned, turned, 6).magnitude
    loss = (contract("jin,jkn->ikn", exactly(V), exactly(V), 6) - exactly(np.eye(6)[..., None])).magnitude
    largest = total(*square.swapaxes(0, 1)).max(axis=0) / (1.0 - total(*loss.swapaxes(0, 1)).max(axis=0))
    return total(root(total(largest)), frobenius(M.rad))


def statics_change(machine: Machine, links: Motion, off: Displacement) -> FloatArray:
    """Bound the change of H with joints and lengths, in the Frobenius norm, (n,); links are those before."""
    L, arm = machine.characteristic_length_m, arm_lengths(machine)[:, None]
    size = norm(np.moveaxis(links.vectors[0].magnitude, 1, 0))
    by_moment = total(times(arm, off.vectors), times(off.arms, total(size, off.vectors)))
    by_moment = total(by_moment / L)
    length = links.lengths[0].lower
    left = rounded_down(length - off.lengths, 1)
    slant = total(arm / L)
    with np.errstate(divide="ignore", invalid="ignore"):
        longer = times(size, root(total(np.ones_like(slant), times(slant, slant))), total(off.lengths / length))
        change = total(root(total(times(off.vectors, off.vectors), times(by_moment, by_moment))), longer)
        parts = np.where((left > 0.0) & (length > 0.0), total(change / left), np.inf)
    return norm(parts)
