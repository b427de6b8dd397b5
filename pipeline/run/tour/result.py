"""What became of a tour."""

from dataclasses import dataclass

from pipeline.atlas.stations import Station
from pipeline.run.tour.legs import Leg


@dataclass(frozen=True)
class Tour:
    """What became of a tour.

    Attributes
    ----------
    stations : tuple of Station
        Where the machine stands first, and the poses that it can be at.
    legs : tuple of Leg
        In their order; the last one leads back, if there is a way.
    left_out : dict
        Poses that are not visited, by name, and why.
    no_return : str
        Why there is no way back; empty if there is one.
    """

    stations: tuple[Station, ...]
    legs: tuple[Leg, ...]
    left_out: dict[str, str]
    no_return: str = ""

    @property
    def visits(self) -> tuple[Leg, ...]:
        """The legs that lead to a pose of the table."""
        return tuple(leg for leg in self.legs if leg.target)
