"""A path to be proven, in exact arithmetic."""

from dataclasses import dataclass

from pipeline.inclusion.closure import Geometry, geometry
from pipeline.inclusion.pieces import Piece, pieces
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class ProofProblem:
    """A path to be proven.

    Attributes
    ----------
    machine : Machine
        The machine.
    path : Path
        The path; its poses are guesses of where to place boxes.
    balls : Geometry
        The machine in balls.
    pieces : tuple of Piece
        The actuators along the path, as exact polynomials.
    least_width : float
        Intervals of s that are narrower are not halved.
    uncertainty : Uncertainty
        How far the machine may be from its configuration.
    """

    machine: Machine
    path: Path
    balls: Geometry
    pieces: tuple[Piece, ...]
    least_width: float
    uncertainty: Uncertainty


def build_problem(machine: Machine, path: Path, least_width: float, uncertainty: Uncertainty = CERTAIN) -> ProofProblem:
    """Turn machine and splines into exact numbers."""
    return ProofProblem(machine, path, geometry(machine), tuple(pieces(path.spline)), least_width, uncertainty)
