"""The proven error of the tool along a path, for given errors of actuators and geometry.

A chain of boxes closes from s = 0 to s = 1, and each bounds how far the tool is from where it should be
(`pipeline.pose_error.box_bound`). Errors of actuators may vary with time; what counts is how far they are off the path.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from flint import fmpq_poly

from pipeline.arguments import require_whole
from pipeline.arrays import FloatArray
from pipeline.certify.chain import BoxBounds, close_chain
from pipeline.certify.problem import build_problem
from pipeline.certify.reasons import Reason
from pipeline.certify.result import ProvenChain, proven_chain
from pipeline.errors import NoSolutionError
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.pieces import Piece
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.pose_error.amplification import DriveAmplification, amplify_drives
from pipeline.pose_error.box_bound import bound_error
from pipeline.progress import QUIET, Monitor
from pipeline.refine.result import Path

WIDEST = 1.0 / 128.0
"""Widest interval of s: over wider ones the bound is coarse."""
_NARROWEST = 1.0 / 256.0
"""Intervals that are no wider than this are not halved only for a sharper bound."""
_SHARP = 0.05
"""Share of the bound that may not be linear in the errors, unless a box is narrow."""
_LEAST_WIDTH = 1e-5
_NOT_SHARP = Reason("the bound is not sharp")


@dataclass(frozen=True, eq=False)
class PoseError:
    """Proven bounds of the tool's error, over n intervals of s.

    Attributes
    ----------
    uncertainty : Uncertainty
        The errors of actuators and geometry.
    edges : (n + 1,)
        Ends of the intervals.
    position_m : (n,)
        How far the tool may be from where it should be.
    rotation_rad : (n,)
        By which angle the platform may be turned against where it should be.
    amplification : DriveAmplification
        How far the tool moves and turns with each drive alone.
    chain : ProvenChain or None
        The proof; None of what was read from a table.
    """

    uncertainty: Uncertainty
    edges: FloatArray
    position_m: FloatArray
    rotation_rad: FloatArray
    amplification: DriveAmplification
    chain: ProvenChain | None = None

    @property
    def middles(self) -> FloatArray:
        """The middles of the intervals. Shape (n,)."""
        return (self.edges[:-1] + self.edges[1:]) / 2.0


def bound_pose_error(
    path: Path, uncertainty: Uncertainty, precision_bits: int = 64, monitor: Monitor = QUIET
) -> PoseError:
    """Bound the error of the tool along a path whose machine is off by up to an uncertainty.

    Raises
    ------
    ArgumentError
        If the precision is not 53 to 4,096 bits.
    NoSolutionError
        If no chain of boxes is proven for errors of this size: where it ends.
    """
    precision_bits = require_whole("precision_bits", precision_bits, 53, 4_096)
    problem = build_problem(path.machine, path, _LEAST_WIDTH, uncertainty)
    with working_precision(precision_bits):
        narrow = replace(problem, pieces=tuple(part for piece in problem.pieces for part in _split(piece)))
        chain = close_chain(narrow, _examine, monitor)
    if chain.failure is not None:
        raise NoSolutionError(
            "pose error",
            f"for errors of this size the pose is not proven beyond s = {chain.failure.s:.6f}: "
            f"{chain.failure.reason.text}",
            "Take smaller errors (certify.pose_error, or --drives-mm ...); gantry-tau certify CONFIG --following says "
            "how far drives may be off.",
            {"s": chain.failure.s},
        )
    bounds = np.array([found for (found,) in chain.bounds])
    edges = np.array([0.0, *(inclusion.box.last for inclusion in chain.inclusions)])
    proof = proven_chain(chain, uncertainty)
    return PoseError(uncertainty, edges, bounds[:, 0], bounds[:, 1], amplify_drives(path, edges), proof)


def _split(piece: Piece) -> list[Piece]:
    """Split a piece into equal ones that are narrow enough, exactly: its boxes would be halved as often."""
    parts = 1
    while (piece.last - piece.first) / parts > WIDEST:
        parts *= 2
    edges = np.linspace(piece.first, piece.last, parts + 1).tolist()
    return [
        Piece(first, last, tuple(fmpq_poly(coefficients) for coefficients in piece.taylor(first)))
        for first, last in pairwise(edges)
    ]


def _examine(box: ProvenBox) -> BoxBounds | Reason:
    """Bound the error over a box; ask for narrower ones while that helps."""
    interval = box.inclusion.box
    width = interval.last - interval.first
    found = bound_error(box)
    if found is None or (width > _NARROWEST and found.rest > _SHARP * found.position_m):
        return _NOT_SHARP
    return (np.array([found.position_m, found.rotation_rad]),)
