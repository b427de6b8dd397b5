"""A proven box with everything that bounds over it are computed from."""

from dataclasses import dataclass
from functools import cached_property

from flint import arb

from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.closure import Geometry
from pipeline.inclusion.displacement import Displacement, of_machines, of_pose
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
    ellipsoid : Ellipsoid or None
        The machines that it is proven for, if these are others than the configured one.
    """

    machine: Machine
    balls: Geometry
    piece: Piece
    series: Piecewise
    inclusion: Inclusion
    ellipsoid: Ellipsoid | None = None

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

    @cached_property
    def displacement(self) -> Displacement:
        """How far joints and lengths may be from those along x(t), or for errors of actuators from those of P a."""
        if self.ellipsoid is None:
            return of_pose(self.balls, self.deviation)
        return of_machines(self.balls, self.series, self.inclusion, self.ellipsoid)
