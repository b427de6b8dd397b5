"""A motion in exact arithmetic: the time law and the path are polynomials, and floats are rational numbers.

On a piece of the time law s(t) is a polynomial, and between two knots so is q(s): the position q(s(t)) of an actuator
is a polynomial in t, of degree 20 for a quartic law and quintic splines, and so are its derivatives by time.
"""

from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

from flint import arb, arb_poly, fmpq, fmpq_poly

from pipeline.inclusion.condition import above, below
from pipeline.inclusion.pieces import Piece, exact, pieces
from pipeline.retime.result import Trajectory

LEAST_PART = fmpq(1, 2**24)
"""Part of a piece of a time law that is not halved any more."""


@dataclass(frozen=True, eq=False)
class LawPiece:
    """A piece of a time law: s = polynomial(t - begins), exactly.

    Attributes
    ----------
    begins : float
        Seconds since the beginning of the motion.
    length : fmpq
        Its duration in seconds.
    polynomial : fmpq_poly
        s by the seconds elapsed in the piece.
    """

    begins: float
    length: fmpq
    polynomial: fmpq_poly


@dataclass(frozen=True, eq=False)
class ExactMotion:
    """A time law and the path it is driven along.

    Attributes
    ----------
    law : tuple of LawPiece
        The pieces of the time law.
    path : tuple of Piece
        The actuators between neighbouring knots.
    firsts : list of float
        Where the pieces of the path begin.
    actuators : list of list of arb_poly
        Positions by s - first, per piece and actuator.
    """

    law: tuple[LawPiece, ...]
    path: tuple[Piece, ...]
    firsts: list[float]
    actuators: list[list[arb_poly]]

    def covering(self, s: arb) -> range:
        """Return the pieces of the path that hold some s of a ball; the first and the last reach beyond their ends."""
        first, last = (max(bisect_right(self.firsts, end) - 1, 0) for end in (below(s), above(s)))
        return range(first, last + 1)

    def position(self, piece: int, actuator: int, s: arb_poly) -> arb_poly:
        """Compose the position of an actuator on a piece of the path with s, a polynomial in time."""
        return self.actuators[piece][actuator](s - arb(exact(self.firsts[piece])))


def exact_motion(trajectory: Trajectory) -> ExactMotion:
    """Convert a trajectory to exact polynomials; balls have the working precision of the caller."""
    path = tuple(pieces(trajectory.path.spline))
    actuators = [[arb_poly([arb(value) for value in q.coeffs()]) for q in piece.polynomials] for piece in path]
    return ExactMotion(exact_law(trajectory), path, [piece.first for piece in path], actuators)


def exact_law(trajectory: Trajectory) -> tuple[LawPiece, ...]:
    """Convert a time law to exact polynomials."""
    law = trajectory.time_law
    rows = law.c[::-1].T.tolist()
    return tuple(
        LawPiece(begins, exact(ends) - exact(begins), fmpq_poly([exact(value) for value in row]))
        for (begins, ends), row in zip(pairwise(law.x.tolist()), rows, strict=True)
    )


def about(piece: LawPiece, time: fmpq) -> arb_poly:
    """Expand s about a time within a piece."""
    shifted = piece.polynomial(fmpq_poly([time, fmpq(1)]))
    return arb_poly([arb(value) for value in shifted.coeffs()])
