"""All a certificate states that can be verified, as it was read: nothing of it is believed."""

from dataclasses import dataclass

from pipeline.certify.result import Bounds, ProvenChain


@dataclass(frozen=True)
class StatedTolerance:
    """How wrong the machine may be, and how many boxes the proof has: none where eps is zero."""

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
        How many there are for the machine as configured.
    bounds : Bounds
        What they prove.
    link_length, coordinates : StatedTolerance or None
        Calibration tolerances; None where none is stated.
    chains : tuple of ProvenChain
        The proofs: that of the machine as configured first.
    """

    path_sha256: str
    premises_sha256: str
    boxes: int
    bounds: Bounds
    link_length: StatedTolerance | None
    coordinates: StatedTolerance | None
    chains: tuple[ProvenChain, ...]
