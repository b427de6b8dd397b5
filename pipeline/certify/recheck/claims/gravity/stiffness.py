"""The least stiffness that gravity gives the drives."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, contract, exactly, times, total, within
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, power
from pipeline.certify.recheck.arithmetic.motion import Motion, follow
from pipeline.certify.recheck.arithmetic.norms import frobenius
from pipeline.certify.recheck.arithmetic.stiffness import stiffness_series
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, lower_bounds
from pipeline.config import Config
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.masses import Masses

STIFFNESS = "gravity stiffness stays above its bound, within the limit"
CLAIMS: tuple[str, ...] = (STIFFNESS,)
KEYS: tuple[str, ...] = ("gravity_stiffness_npm",)

_DIAGONAL = np.arange(len(ACTUATORS))


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the least eigenvalue over some boxes from below; none where it is not limited."""
    if machine.masses is None or np.isinf(machine.gravity_stiffness_npm):
        return np.empty((0, 2))
    least = stiffness_bounds(machine, machine.masses, segment.boxes, segment.inclusions.image)
    return lower_bounds(least.min(keepdims=True))


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bound of the least eigenvalue for every s, if it is limited."""
    if not len(evidence.found):
        yield Claim(STIFFNESS, verified=KEYS[0] not in stated.ranges, found="gravity stiffness is not limited")
        return
    if KEYS[0] not in stated.ranges:
        yield Claim(STIFFNESS, verified=False, found="not stated: certified before it was bounded")
        return
    found, proven = float(evidence.least[0]), float(stated.ranges[KEYS[0]].values[0, 0])
    allowed = evidence.machine.gravity_stiffness_npm
    kept = allowed <= proven <= found
    yield Claim(STIFFNESS, kept, f"{found:.6g}; stated {proven:.6g}, allowed {allowed:.6g} N/m")


def stiffness_bounds(machine: Machine, masses: Masses, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound the least eigenvalue of K over each box from below, for poses within `deviation` (6, n) of the cubics.

    The statement is that of `pipeline.inclusion.gravity.stiffness`. Shape (n,); -inf if H may be singular.
    """
    h = boxes.half
    with np.errstate(over="ignore", invalid="ignore"):
        about, everywhere = (
            stiffness_series(machine, masses, _off_the_cubic(machine, motion, deviation))
            for motion in (boxes.at, boxes.over)
        )
        M0, M1 = (_symmetric(K.mid) for K in about[:2])
        sizes = ((about[0] - exactly(M0)).magnitude, (about[1] - exactly(M1)).magnitude, everywhere[2].magnitude)
        rest = total(*(times(power(h, order), frobenius(size)) for order, size in enumerate(sizes)))
        ends = [_least_eigenvalues(exactly(M0) + exactly(M1) * exactly(t), rest) for t in (-h, h)]
    return np.where(np.isfinite(rest), np.minimum(*ends), -np.inf)


def _least_eigenvalues(M: Enclosure, off: FloatArray) -> FloatArray:
    """Bound the least eigenvalue of symmetric matrices (5, 5, n), off by `off` (n,) in the Frobenius norm. Shape (n,).

    By Gershgorin's circles after a congruence with nearly orthogonal eigenvectors.
    """
    middle = _symmetric(M.mid)
    off = total(off, frobenius((M - exactly(middle)).magnitude))
    known = np.where(np.isfinite(off), middle, 0.0)
    V = exactly(np.moveaxis(np.linalg.eigh(np.moveaxis(known, -1, 0))[1], 0, -1))
    A = contract("jin,jkn->ikn", V, contract("ijn,jkn->ikn", exactly(known), V, 5), 5)
    beside = A.magnitude
    beside[_DIAGONAL, _DIAGONAL] = 0.0
    diagonal = A[_DIAGONAL, _DIAGONAL]
    circles = Enclosure(diagonal.mid, total(diagonal.rad, *beside.swapaxes(0, 1)))
    squares = contract("jin,jkn->ikn", V, V, 5) - exactly(np.eye(len(ACTUATORS))[..., None])
    lengths = Enclosure(np.ones_like(off), total(*squares.magnitude.swapaxes(0, 1)).max(axis=0))
    return (exactly(circles.lower.min(axis=0)) * lengths.inverse() - within(off)).lower


def _symmetric(matrices: FloatArray) -> FloatArray:
    return (matrices + matrices.swapaxes(0, 1)) / 2.0


def _off_the_cubic(machine: Machine, motion: Motion, deviation: FloatArray) -> Motion:
    """Evaluate the closures for every pose that is off the cubics by a constant within the deviation."""
    pose = Enclosure(motion.pose.mid, motion.pose.rad.copy())
    pose.rad[0] = total(pose.rad[0], deviation)
    return follow(machine, pose, motion.q)
