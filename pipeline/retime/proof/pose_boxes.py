"""The poses along a path: boxes that hold one pose at every s, each proven to continue the pose of the one before.

The first box holds the known pose at s = 0, so that all hold the poses of the assembly that the path begins in. A pose
at the end of a box is within its image about its cubic, and this lies within the next box at that s: the one pose of
either is the same.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_poly

from pipeline.arrays import FloatArray
from pipeline.errors import ForwardKinematicsError, NoSolutionError
from pipeline.inclusion.closure import Geometry, geometry
from pipeline.inclusion.krawczyk import Box, Inclusion, Piecewise, along, include
from pipeline.inclusion.pieces import Piece, exact, middle, pieces
from pipeline.refine.result import Path

_THIN = 2e-7
"""Largest distance of a pose from the cubic of its box, in metres and radians: loads follow from its derivatives.

Boxes reach four times as far, so that a box holds whatever pose its neighbour does where they meet."""
_LEAST_WIDTH = 2.0**-20


@dataclass(frozen=True, eq=False)
class PoseBox:
    """A box over an interval of s within a piece of the path.

    Attributes
    ----------
    piece : Piece
        The actuators there.
    series : Piecewise
        The closures along the cubic of the box.
    inclusion : Inclusion
        The proof of the box.
    """

    piece: Piece
    series: Piecewise
    inclusion: Inclusion

    @property
    def interval(self) -> tuple[float, float]:
        """Where the box begins and ends."""
        return self.inclusion.box.first, self.inclusion.box.last

    @property
    def centre(self) -> float:
        """The middle of the interval, about which everything is expanded."""
        return middle(*self.interval)[0]

    def cubic(self, s: float) -> list[arb]:
        """Evaluate the cubic of the box at some s."""
        offset = arb(exact(s) - exact(self.centre))
        return [arb_poly([arb(value) for value in column])(offset) for column in self.inclusion.box.pose.T.tolist()]


def pose_boxes(path: Path) -> list[PoseBox]:
    """Prove boxes from s = 0 to s = 1.

    Raises
    ------
    NoSolutionError
        Where an interval is too narrow to be halved, and its pose is still not proven to be one.
    """
    balls, found = geometry(path.machine), list[PoseBox]()
    for piece in pieces(path.spline):
        waiting = [(piece.first, piece.last)]
        while waiting:
            interval = waiting.pop()
            box = _prove(balls, path, piece, interval)
            if box is not None and _continues(box, interval[0], *_before(path, found)):
                found.append(box)
            elif interval[1] - interval[0] < _LEAST_WIDTH:
                raise _unproven(interval[0])
            else:
                centre, _ = middle(*interval)
                waiting += [(centre, interval[1]), (interval[0], centre)]
    return found


def nodes(interval: tuple[float, float], count: int) -> FloatArray:
    """Return Chebyshev nodes of an interval."""
    centre, half = middle(*interval)
    return np.asarray(centre + half * np.cos(np.pi * (np.arange(count) + 0.5) / count))


def interpolated(interval: tuple[float, float], values: FloatArray) -> FloatArray:
    """Interpolate values (n, k) at the Chebyshev nodes of an interval: coefficients about its middle, (n, k)."""
    centre, half = middle(*interval)
    at = np.vander((nodes(interval, len(values)) - centre) / half, increasing=True)
    return np.asarray(np.linalg.solve(at, values) / half ** np.arange(len(values))[:, None])


def _prove(balls: Geometry, path: Path, piece: Piece, interval: tuple[float, float]) -> PoseBox | None:
    """Prove a box about the cubic through four poses; None if that fails, or if the poses are far from the cubic."""
    try:
        cubic = interpolated(interval, path.pose(nodes(interval, 4)))
    except ForwardKinematicsError:
        return None
    box = Box(*interval, cubic, np.full(cubic.shape[1], 4.0 * _THIN))
    series = along(balls, piece, box)
    inclusion = include(balls, series, box)
    if inclusion is None or not all(k < _THIN for k in inclusion.image):
        return None
    return PoseBox(piece, series, inclusion)


def _before(path: Path, found: list[PoseBox]) -> tuple[list[arb], list[arb]]:
    """Give the pose that the next box has to hold, and how far from it that may be: at the start, the known pose."""
    if found:
        return found[-1].cubic(found[-1].interval[1]), found[-1].inclusion.image
    return [arb(value) for value in path.pose(0.0).tolist()], [arb(0)] * 6


def _continues(box: PoseBox, s: float, pose: list[arb], within: list[arb]) -> bool:
    """Return whether a pose, known to within some bounds, lies within the box at s."""
    radii = (arb(value) for value in box.inclusion.box.radius.tolist())
    rows = zip(box.cubic(s), pose, within, radii, strict=True)
    return all((x - y).abs_upper() + far < r for x, y, far, r in rows)


def _unproven(s: float) -> NoSolutionError:
    return NoSolutionError(
        "retime",
        f"forces in motion cannot be bounded: the pose at s = {s:.4f} is not proven to be the only one near it",
        "Keep the path farther from singularities: lower refine.kappa_max.",
        {"limit": "force", "s": s},
    )
