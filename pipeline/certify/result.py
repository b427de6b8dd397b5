"""The result of a proof: a certificate, or where and why it ends."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.arrays import arrays_sha256
from pipeline.certify.bounds import Bounds
from pipeline.certify.chain import Chain
from pipeline.certify.reasons import ProofFailure
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.refine.result import Path

CERTIFIED = "certified"
NOT_CERTIFIED = "not certified"


@dataclass(frozen=True, eq=False)
class ProvenChain:
    """Boxes that close from s = 0 to s = 1 for every machine within the uncertainty.

    Attributes
    ----------
    uncertainty : Uncertainty
        How far the machine may be from its configuration.
    boxes : n boxes
        In order.
    joints : n + 1 boxes
        Each at a single s, where the boxes begin and end and are proven to meet.
    """

    uncertainty: Uncertainty
    boxes: tuple[Box, ...]
    joints: tuple[Box, ...]


@dataclass(frozen=True, eq=False)
class Tolerance:
    """A tolerance of calibration or following errors: the largest eps found for which the chain closes, and that chain.

    Attributes
    ----------
    eps_m : float
        The proven one; 0 if none was proven.
    refuted_m : float
        The least eps tried for which the proof failed.
    fails_m : float
        An eps at which a sampled machine fails (Monte Carlo); infinite if none did.
    chain : ProvenChain or None
        The proof.
    """

    eps_m: float
    refuted_m: float
    fails_m: float
    chain: ProvenChain | None


@dataclass(frozen=True, eq=False)
class Certificate:
    """The proof of a path, as far as it goes.

    Attributes
    ----------
    path_sha256 : str
        Hash of the splines and known poses of the path.
    premises_sha256 : str
        Hash of the machine, the limits and the ends.
    precision_bits : int
        Precision of the ball arithmetic.
    chain : ProvenChain
        Boxes proven for the machine as configured.
    bounds : Bounds or None
        Bounds over all boxes; None if no box is proven.
    failure : ProofFailure or None
        Where and why the proof ends; None if the path is certified.
    link_length, coordinates : Tolerance or None
        Calibration tolerances; None if they were not searched.
    following : mapping
        Tolerances of following errors, by the names of `following_weights`; empty if they were not searched.
    out_of_step_s : float or None
        By how much actuators at their velocity limits may be early or late at most; None if that was not searched.
    """

    path_sha256: str
    premises_sha256: str
    precision_bits: int
    chain: ProvenChain
    bounds: Bounds | None
    failure: ProofFailure | None
    link_length: Tolerance | None = None
    coordinates: Tolerance | None = None
    following: Mapping[str, Tolerance] = field(default_factory=dict)
    out_of_step_s: float | None = None

    @property
    def verdict(self) -> str:
        """Whether the path is certified, in words."""
        return CERTIFIED if self.failure is None else NOT_CERTIFIED


def proven_chain(chain: Chain, uncertainty: Uncertainty) -> ProvenChain:
    """Keep what is needed to verify a chain again."""
    boxes, joints = (tuple(proven.box for proven in part) for part in (chain.inclusions, chain.joints))
    return ProvenChain(uncertainty, boxes, joints)


def path_sha256(path: Path) -> str:
    """Hash everything that positions and poses along a path follow from, bit by bit.

    These are the degree, knots and coefficients of its splines and the known poses with their s.
    """
    arrays = {
        "knots": path.spline.t,
        "coefficients": path.spline.c,
        "node_s": path.node_s,
        "node_pose": path.node_pose,
    }
    return arrays_sha256(f"degree {int(path.spline.k)}", arrays)
