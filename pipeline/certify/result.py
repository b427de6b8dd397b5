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
    within_limits : bool
        Whether every box keeps the limits of kappa, distances and joints under these errors, too.
    profile_m : (n,) or None
        Errors of every actuator over each box, in place of the uncertainty's, which are the least of them; at a joint,
        those of the neighbour with the smaller ones. None: the same errors for all s.
    """

    uncertainty: Uncertainty
    boxes: tuple[Box, ...]
    joints: tuple[Box, ...]
    within_limits: bool = False
    profile_m: tuple[float, ...] | None = None


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
    tilt_reserve_deg : (2,) or None
        What rx and rz may be off the path by, proven: what their limits need in reserve. None if that was not asked.
    late_s : float or None
        By how much actuators at their velocity limits may be early or late; None where it is not about velocities.
    stopped_by : ProofFailure or None
        Where and why the proof failed for the least eps that was tried in vain.
    """

    eps_m: float
    refuted_m: float
    fails_m: float
    chain: ProvenChain | None
    tilt_reserve_deg: tuple[float, float] | None = None
    late_s: float | None = None
    stopped_by: ProofFailure | None = None


@dataclass(frozen=True, eq=False)
class FollowingTolerances:
    """How far the actuators may be off the path: by the names of `following_weights`, as two different claims.

    Attributes
    ----------
    within_limits : mapping
        The motion stays regular and on its branch, *and* keeps the limits of kappa, distances and joints.
    on_branch : mapping
        The motion stays regular and on its branch, whatever limits it breaks.
    calibrated : Tolerance or None
        On its branch, with all actuators off alike and the calibration wrong by `certify.following_length_m` and
        `certify.following_coordinate_m` at the same time; None if these are zero.
    profiles : mapping
        The errors of all actuators alike over s, "within_limits" and "on_branch": each one chain.
    """

    within_limits: Mapping[str, Tolerance] = field(default_factory=dict)
    on_branch: Mapping[str, Tolerance] = field(default_factory=dict)
    calibrated: Tolerance | None = None
    profiles: Mapping[str, ProvenChain] = field(default_factory=dict)


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
    following : FollowingTolerances or None
        Tolerances of following errors; None if they were not searched.
    """

    path_sha256: str
    premises_sha256: str
    precision_bits: int
    chain: ProvenChain
    bounds: Bounds | None
    failure: ProofFailure | None
    link_length: Tolerance | None = None
    coordinates: Tolerance | None = None
    following: FollowingTolerances | None = None

    @property
    def verdict(self) -> str:
        """Whether the path is certified, in words."""
        return CERTIFIED if self.failure is None else NOT_CERTIFIED


def proven_chain(chain: Chain, uncertainty: Uncertainty, *, within_limits: bool = False) -> ProvenChain:
    """Keep what is needed to verify a chain again."""
    boxes, joints = (tuple(proven.box for proven in part) for part in (chain.inclusions, chain.joints))
    return ProvenChain(uncertainty, boxes, joints, within_limits)


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
