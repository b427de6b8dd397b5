"""Bodies as arrays: hulls of points that move with a frame, and the pairs of them that are kept apart."""

from dataclasses import dataclass, replace
from enum import Enum, auto

from pipeline.arrays import FloatArray, IntArray
from pipeline.config.machine.bodies import LINK_NAMES


class FrameKind(Enum):
    """What the points of a hull move with.

    Points of the platform are given in its frame, from the TCP; those of a cart from the point of its rail that it is
    at; those of a link as part of its length and metres along its axis, from the cart joint; the others in space.
    """

    PLATFORM = auto()
    CART = auto()
    LINK = auto()
    FIXED = auto()


@dataclass(frozen=True, eq=False)
class SweptHull:
    """All points within a radius of the convex hull of points.

    Attributes
    ----------
    name : str
        The body it is of: "nose", "link 1", "tube 2b".
    kind : FrameKind
        What it moves with,
    number : int
        and which of them: arm 0 to 2 of a cart, link 0 to 5, rail 1 to 3 of what is fixed to one, 0 elsewhere.
    points_m : (k, 3)
        The points; (k, 2) for a link: a point C + (f + s / L) (A - C) of link CA of length L is (f, s).
    radius_m : float
        The radius.
    endless : bool
        Whether it is endless along X: the points are corners of its profile, x zero.
    attached : bool
        Whether it is a body at an end of a link, beside the link itself: its points have one share f of the length.
    """

    name: str
    kind: FrameKind
    number: int
    points_m: FloatArray
    radius_m: float
    endless: bool = False
    attached: bool = False

    @property
    def is_link(self) -> bool:
        """Whether it is a link, or the rod or tube of one."""
        return self.kind == FrameKind.LINK and not self.attached

    @property
    def is_obstacle(self) -> bool:
        """Whether it is fixed in space, with ends along X: distances from it depend on x."""
        return self.kind == FrameKind.FIXED and not self.endless

    @property
    def moves_with(self) -> str:
        """What it moves with, in words."""
        if self.kind == FrameKind.FIXED:
            return f"rail {self.number}" if self.number else "frame"
        if self.kind == FrameKind.PLATFORM:
            return "platform"
        if self.kind == FrameKind.CART:
            return f"cart {self.number + 1}"
        return f"link {LINK_NAMES[self.number][1:]}" if self.attached else "link"


@dataclass(frozen=True)
class Neighbours:
    """Two bodies that touch by construction.

    Attributes
    ----------
    name : str
        The pair: "nose and link 3a".
    why : str
        What makes them neighbours.
    treatment : str
        What is checked all the same.
    """

    name: str
    why: str
    treatment: str


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of a machine.

    Attributes
    ----------
    hulls : tuple of SweptHull
        All hulls; a link that is cut short at a joint for some of its pairs is there once for each length.
    pairs : tuple of (int, int)
        The pairs of hulls that are kept apart, m of them.
    names : tuple of str
        Their names: "nose and link 2a".
    clearance_m : float
        Least distance between surfaces.
    neighbours : tuple of Neighbours
        Pairs that touch by construction, and pairs that are ignored.
    """

    hulls: tuple[SweptHull, ...]
    pairs: tuple[tuple[int, int], ...]
    names: tuple[str, ...]
    clearance_m: float
    neighbours: tuple[Neighbours, ...]

    def only(self, pairs: IntArray) -> "Bodies":
        """Keep some of the pairs (k,), by their numbers, and the hulls that they are of."""
        kept = [self.pairs[number] for number in pairs.tolist()]
        used = sorted({number for pair in kept for number in pair})
        new = {number: k for k, number in enumerate(used)}
        return replace(
            self,
            hulls=tuple(self.hulls[number] for number in used),
            pairs=tuple((new[i], new[j]) for i, j in kept),
            names=tuple(self.names[number] for number in pairs.tolist()),
        )

    def radii_m(self, pair: tuple[int, int]) -> float:
        """Sum of the radii of a pair: distances of hulls less this are those of surfaces."""
        return self.hulls[pair[0]].radius_m + self.hulls[pair[1]].radius_m

    def is_endless(self, pair: tuple[int, int]) -> bool:
        """Whether one of a pair is endless along X, so that x plays no role in their distance."""
        return any(self.hulls[number].endless for number in pair)
