"""What the proof makes: a certificate, or where and why it breaks."""

import hashlib
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.chain import Break, Chain
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.refine.result import Path

F = TypeVar("F")

CERTIFIED = "certified"
NOT_CERTIFIED = "not certified"


@dataclass(frozen=True, eq=False)
class ProvenChain:
    """Boxes that close from s = 0 to s = 1 for every machine within the uncertainty.

    Attributes
    ----------
    uncertainty : Uncertainty
        What may be wrong about the machine.
    boxes : n boxes
        In order.
    joints : n + 1 boxes
        Each of a single s: where the boxes begin and end, and are proven to meet.
    """

    uncertainty: Uncertainty
    boxes: tuple[Box, ...]
    joints: tuple[Box, ...]


@dataclass(frozen=True, eq=False)
class Bounds:
    """What is proven for every s; empty boxes prove nothing.

    Attributes
    ----------
    kappa : float
        Upper bound of the condition number.
    kappa_s : float
        The middle of the box with the largest bound.
    det_sign : int
        Sign of det H along the whole path.
    pairs : tuple of str
        The pairs whose distances are bounded.
    distances_m : (pairs,)
        Lower bounds.
    actuators_m : (5, 2)
        Bounds below and above of carts and telescopes.
    tilt_rad : (2,)
        Upper bounds of |rx| and |rz|.
    start_miss, goal_miss : float
        How far the ends are from the task's poses at most, metres or radians.
    """

    kappa: float
    kappa_s: float
    det_sign: int
    pairs: tuple[str, ...]
    distances_m: FloatArray
    actuators_m: FloatArray
    tilt_rad: FloatArray
    start_miss: float
    goal_miss: float


@dataclass(frozen=True, eq=False)
class Tolerance:
    """How wrong the machine may be: the largest eps found for which the chain closes, and the chain.

    Attributes
    ----------
    eps_m : float
        Proven: 0 where none was.
    refuted_m : float
        The least eps tried for which the proof did not succeed.
    fails_m : float
        An eps at which some machine was seen to fail (Monte Carlo).
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
        Of the splines it speaks of.
    premises_sha256 : str
        Of the machine, the limits and the ends it speaks of.
    precision_bits : int
        Of the ball arithmetic.
    chain : ProvenChain
        Boxes proven for the machine as configured.
    bounds : Bounds or None
        Over all of them; None where not even one is proven.
    broken : Break or None
        Where and why the path is refused.
    link_length, coordinates : Tolerance or None
        Calibration tolerances; None where they were not searched.
    """

    path_sha256: str
    premises_sha256: str
    precision_bits: int
    chain: ProvenChain
    bounds: Bounds | None
    broken: Break | None
    link_length: Tolerance | None = None
    coordinates: Tolerance | None = None

    @property
    def verdict(self) -> str:
        """Say whether the path is certified."""
        return CERTIFIED if self.broken is None else NOT_CERTIFIED


def proven_chain(chain: Chain[F], uncertainty: Uncertainty) -> ProvenChain:
    """Keep of a chain what it takes to verify it again."""
    boxes, joints = (tuple(proven.box for proven in part) for part in (chain.inclusions, chain.joints))
    return ProvenChain(uncertainty, boxes, joints)


def path_sha256(path: Path) -> str:
    """Hash a path's splines: degree, knots and coefficients, bit by bit."""
    digest = hashlib.sha256(str(path.spline.k).encode())
    for array in (path.spline.t, path.spline.c):
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()
