"""The bound of kappa, and the sign of det H."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.determinant import det_signs
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, exactly, root, times, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, linear_inverse, power, residual_of_inverse
from pipeline.certify.recheck.arithmetic.norms import arm_lengths, frobenius, joint_shift, norm
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
    kappa, sign = kappa_bounds(machine, segment.boxes, segment.inclusions.image)
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


def kappa_bounds(machine: Machine, boxes: Boxes, deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bound kappa from above and find the sign of det H, each (n,), for poses within `deviation` (6, n) of the cubics.

    The sign is 0, and the bound infinite, if H may be singular.
    """
    at, over = boxes.at.statics(), boxes.over.statics()
    H = [at[0], at[1], over[2]]
    Y = linear_inverse(H)
    h = boxes.half
    off = statics_change(machine, boxes, deviation)
    bound_Y = _largest(exactly(Y[0]), exactly(Y[1]), h)
    bound_H = total(_largest(H[0], H[1], h), times(power(h, 2), frobenius(H[2].magnitude)), off)
    squares = residual_of_inverse([exactly(part) for part in Y], H, h)
    miss = total(frobenius(squares), times(bound_Y, off))
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.where(miss < 1.0, total(times(bound_H, bound_Y) / (1.0 - miss)), np.inf)
    # ||I - Y0 H'|| < 1: the determinants of Y0 and H have the same sign.
    return kappa, np.where(miss < 1.0, det_signs(Y[0]), 0.0)


def _largest(M0: Enclosure, M1: Enclosure, h: FloatArray) -> FloatArray:
    """Bound ||M0 + M1 t||_2 for |t| <= h, (n,): convex in t, so at the ends, by nearly orthogonal singular vectors."""
    bounds = []
    for t in (-h, h):
        end = M0 + M1 * exactly(t)
        V = np.linalg.svd(np.moveaxis(end.mid, -1, 0))[2].transpose(2, 1, 0)
        turned = contract("ijn,jkn->ikn", exactly(end.mid), exactly(V), 6)
        square = contract("jin,jkn->ikn", turned, turned, 6).magnitude
        loss = (contract("jin,jkn->ikn", exactly(V), exactly(V), 6) - exactly(np.eye(6)[..., None])).magnitude
        largest = total(*square.swapaxes(0, 1)).max(axis=0) / (1.0 - total(*loss.swapaxes(0, 1)).max(axis=0))
        bounds.append(total(root(total(largest)), frobenius(end.rad)))
    return np.maximum(*bounds)


def statics_change(machine: Machine, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound the change of H with the pose, in the Frobenius norm, (n,)."""
    arm, turn = arm_lengths(machine)[:, None], total(*deviation[3:])
    by_vector = joint_shift(machine, deviation)
    size = norm(np.moveaxis(boxes.over.vectors[0].magnitude, 1, 0))
    by_moment = total(times(arm, by_vector), times(arm, turn, total(size, by_vector)))
    by_moment = total(by_moment / machine.characteristic_length_m)
    length = boxes.over.lengths[0].lower
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = [np.where(length > 0.0, total(part / length), np.inf) for part in (by_vector, by_moment)]
    return norm(np.concatenate(parts))
