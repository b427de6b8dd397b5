"""Everything in a certificate that can be verified, as it was read; nothing of it is trusted."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.certify.bounds import Bounds
from pipeline.certify.result import ProvenChain


@dataclass(frozen=True)
class StatedTolerance:
    """A tolerance, the number of boxes of its proof, none if eps is zero, and what rx and rz need in reserve.

    What stopped the search, and at which s, is no claim: that more was not proven proves nothing.
    """

    eps_m: float
    boxes: int
    tilt_reserve_deg: tuple[float, float] | None = None
    stopped_by: tuple[str, float] | None = None


@dataclass(frozen=True)
class StatedCalibrated:
    """A tolerance of following errors, beside calibration errors of lengths and coordinates."""

    tolerance: StatedTolerance
    length_m: float
    coordinate_m: float


@dataclass(frozen=True)
class StatedFollowing:
    """Tolerances of following errors by their names: within limits, on the branch, and beside calibration errors."""

    within_limits: Mapping[str, StatedTolerance] = field(default_factory=dict)
    on_branch: Mapping[str, StatedTolerance] = field(default_factory=dict)
    calibrated: StatedCalibrated | None = None


@dataclass(frozen=True)
class StatedMachines:
    """What is stated of all machines that a calibration leaves possible.

    Attributes
    ----------
    sigma : float
        k: standard deviations of every combination of parameters.
    dimensions : int
        In how many directions the machines differ.
    probability : float
        How probable it is that all parameters together are within the ellipsoid.
    boxes : int
        Number of boxes of the proof.
    within_limits : bool
        Whether limits are kept; otherwise the motion is merely regular and on one branch.
    calibration_sha256 : str
        Hash of the calibration's file.
    parameters : tuple of 56
        Their names.
    tilt_reserve_deg, actuator_reserve_m : tuples of 2 and 5
        How far machines may be off the path: rx and rz, carts and telescopes.
    ranges_kept : bool
        Whether tilts, travel and strokes stay within their limits with that, too.
    """

    sigma: float
    dimensions: int
    probability: float
    boxes: int
    within_limits: bool
    calibration_sha256: str
    parameters: tuple[str, ...]
    tilt_reserve_deg: tuple[float, ...]
    actuator_reserve_m: tuple[float, ...]
    ranges_kept: bool


@dataclass(frozen=True, eq=False)
class Statement:
    """What a certificate states.

    Attributes
    ----------
    path_sha256, premises_sha256 : str
        Hashes of the path, and of machine, limits and ends.
    boxes : int
        Number of boxes for the machine as configured.
    bounds : Bounds
        What they prove.
    link_length, coordinates : StatedTolerance or None
        Calibration tolerances; None if not stated.
    following : StatedFollowing
        Tolerances of following errors; none if not stated.
    machines : StatedMachines or None
        All machines that a calibration leaves possible; None if not stated.
    chains : tuple of ProvenChain
        The proofs, that of the machine as configured first.
    """

    path_sha256: str
    premises_sha256: str
    boxes: int
    bounds: Bounds
    link_length: StatedTolerance | None
    coordinates: StatedTolerance | None
    chains: tuple[ProvenChain, ...]
    following: StatedFollowing = field(default_factory=StatedFollowing)
    machines: StatedMachines | None = None
