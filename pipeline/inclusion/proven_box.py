"""A proven box with everything that bounds over it are computed from."""

from dataclasses import dataclass
from functools import cached_property

from flint import arb

from pipeline.inclusion.closure import Geometry
from pipeline.inclusion.following import Erring, erring
from pipeline.inclusion.krawczyk import Inclusion, Piecewise
from pipeline.inclusion.pieces import Piece
from pipeline.machine.geometry import Machine


@dataclass(frozen=True, eq=False)
class ProvenBox:
    """A box that holds exactly one regular pose for every s of its interval.

    Attributes
    ----------
    machine : Machine
        The machine.
    balls : Geometry
        The machine in balls.
    piece : Piece
        The actuators over the interval, as exact polynomials.
    series : Piecewise
        The closures along the box.
    inclusion : Inclusion
        The proof of the box.
    """

    machine: Machine
    balls: Geometry
    piece: Piece
    series: Piecewise
    inclusion: Inclusion

    @cached_property
    def erring(self) -> Erring | None:
        """The closures for all errors of the actuators; None if there are none."""
        return erring(self.balls, self.series.over, self.inclusion.following, self.deviation)

    @property
    def deviation(self) -> list[arb]:
        """Bounds of how far the poses are from x(t), or x(t) + P a, for bounds of limits: six balls.

        With errors these are the radii, which other arithmetic verifies, too: its own images are wider.
        """
        inclusion = self.inclusion
        return [arb(r) for r in inclusion.box.radius.tolist()] if inclusion.following.any else inclusion.image
