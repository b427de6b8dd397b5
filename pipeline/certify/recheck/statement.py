"""Everything in a certificate that can be verified, as it was read; nothing of it is trusted."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.certify.bounds import Bounds
from pipeline.certify.result import ProvenChain


@dataclass(frozen=True)
class StatedTolerance:
    """A tolerance, and the number of boxes of its proof: none if eps is zero."""

    eps_m: float
    boxes: int


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
    following : mapping
        Tolerances of following errors by their names; none if not stated.
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
    following: Mapping[str, StatedTolerance] = field(default_factory=dict)
