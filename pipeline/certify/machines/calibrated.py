"""The proof of a path for every machine that a calibration leaves possible."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.chain import BoxBounds, Chain, Examiner, close_chain
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.problem import build_problem
from pipeline.certify.reasons import ProofFailure, Reason
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.config import Config
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.condition import above
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.limits import error_proven_limits
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path

_LEAST_WIDTH = 1e-4
"""A chain that closes for many machines does not need narrow boxes."""
_MARGIN, _SLACK_DEG, _SLACK_M = 1.01, 1e-6, 1e-9
"""What reserves are enlarged by, so that other arithmetic can verify them."""


@dataclass(frozen=True, eq=False)
class Reserves:
    """How far machines may be off the path: what limits that the path may touch need in reserve.

    Attributes
    ----------
    tilt_deg : (2,)
        Of rx and rz.
    actuators_m : (5,)
        Of carts and telescopes, from where their encoders have them.
    """

    tilt_deg: tuple[float, ...]
    actuators_m: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class CalibratedProof:
    """What is proven for all machines of an ellipsoid.

    Attributes
    ----------
    chain : ProvenChain or None
        The proof: within the limits of kappa, distances and joints, or merely regular and on one branch. None: neither.
    reserves : Reserves
        How far machines may be off the path; none without a proof.
    broken : ProofFailure or None
        Where and why limits are not proven to be kept.
    failure : ProofFailure or None
        Where and why nothing is proven.
    """

    chain: ProvenChain | None
    reserves: Reserves
    broken: ProofFailure | None
    failure: ProofFailure | None


def prove_calibrated(
    config: Config, machine: Machine, path: Path, ellipsoid: Ellipsoid, monitor: Monitor = QUIET
) -> CalibratedProof:
    """Prove a path for all machines of an ellipsoid: within the limits, or else at least regular and on one branch."""
    uncertainty = Uncertainty(ellipsoid=ellipsoid)
    with working_precision(config.certify.precision_bits):
        problem = build_problem(machine, path, _LEAST_WIDTH, uncertainty)
        keep = build_error_examiner(error_proven_limits(config, machine))
        within = close_chain(problem, _measuring(keep), monitor)
        chain = within if within.failure is None else close_chain(problem, _measuring(_accept), monitor)
    if chain.failure is not None:
        return CalibratedProof(None, Reserves((), ()), within.failure, chain.failure)
    proof = proven_chain(chain, uncertainty, within_limits=chain is within)
    return CalibratedProof(proof, _reserves(chain), within.failure, None)


def _accept(box: ProvenBox) -> BoxBounds | Reason:
    return ()


def _measuring(examine: Examiner) -> Examiner:
    """Bound how far machines may be off, too."""

    def measure(box: ProvenBox) -> BoxBounds | Reason:
        if isinstance(found := examine(box), Reason):
            return found
        off = box.displacement
        tilts = [above(off.pose[column]) for column in TILT_COLUMNS]
        return np.array(tilts), np.array([above(one) for one in off.actuators])

    return measure


def _reserves(chain: Chain) -> Reserves:
    tilts, actuators = (np.max(part, axis=0) for part in zip(*chain.bounds, strict=True))
    return Reserves(_numbers(_MARGIN * np.rad2deg(tilts) + _SLACK_DEG), _numbers(_MARGIN * actuators + _SLACK_M))


def _numbers(values: FloatArray) -> tuple[float, ...]:
    return tuple(values.tolist())
