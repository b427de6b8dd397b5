"""Straight ends of the path: cones around their lines, in which the TCP stays up to the approach pose.

At a distance a along the line from the start or the goal, the TCP is off the line by at most a tan(3 degrees), so that
every chord from there is within 3 degrees of it; the platform tilts by at most one degree against that end. Nodes keep
two thirds of both: the path bulges between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits.approach import approaches
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.refine.coarse import corner_parameters
from pipeline.refine.result import Path
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route

_HALF_ANGLE_RAD, _TILT_RAD = np.deg2rad(3.0), np.deg2rad(1.0)
_AT_NODES = 2.0 / 3.0
_FACES = 8
"""Faces of the pyramid around the cone of the nodes: its edges are 8 per cent farther from the line."""


@dataclass(frozen=True, eq=False)
class StraightEnd:
    """A straight end of a path.

    Attributes
    ----------
    name : str
        "start" or "goal".
    end : (6,)
        That pose.
    outward : (3,)
        Unit vector from there to the approach pose.
    step : int
        Step of the route that is the approach pose.
    s_end, s : float
        Parameters of both poses.
    """

    name: str
    end: FloatArray
    outward: FloatArray
    step: int
    s_end: float
    s: float

    def inside(self, s: FloatArray) -> BoolArray:
        """Tell which parameters (n,) are between both poses, these included. Shape (n,)."""
        return np.asarray((s - self.s_end) * (s - self.s) <= 0.0)

    def excess(self, pose: FloatArray) -> FloatArray:
        """Compute how far poses (n, 6) are outside the cone, metres, and tilted too much, radians. Shape (n, 2)."""
        away = pose[:, :3] - self.end[:3]
        along = away @ self.outward
        across = np.linalg.norm(away - along[:, None] * self.outward, axis=1)
        tilt = np.abs(pose[:, TILT_COLUMNS] - self.end[list(TILT_COLUMNS)]).max(axis=1)
        return np.column_stack([across - np.tan(_HALF_ANGLE_RAD) * along, tilt - _TILT_RAD])


@dataclass(frozen=True, eq=False)
class Walls:
    """Planes that the TCP at nodes stays behind: normal . (x, y, z) <= offset.

    Attributes
    ----------
    node : (w,)
        Which node each plane is for.
    normal, offset : (w, 3), (w,)
        The planes, metres.
    """

    node: IntArray
    normal: FloatArray
    offset: FloatArray

    def __len__(self) -> int:
        return len(self.node)


NO_WALLS = Walls(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty(0))


def straight_ends(config: Config, route: Route, coarse: Path) -> tuple[StraightEnd, ...]:
    """List the straight ends of the path along a route."""
    found, corners = [], corner_parameters(coarse)
    for approach in approaches(config):
        moves, outward = approach.moves(step_sizes(config.route)), np.array(approach.outward)
        end, step = (0, moves) if approach.name == "start" else (len(route) - 1, len(route) - 1 - moves)
        found.append(
            StraightEnd(approach.name, route.pose[end], outward, step, float(corners[end]), float(corners[step]))
        )
    return tuple(found)


def walls_at(ends: Sequence[StraightEnd], s: FloatArray) -> Walls:
    """Wall in the nodes s (k,) that are within straight ends: pyramids around the cones of nodes."""
    parts = [NO_WALLS]
    angles = 2.0 * np.pi * np.arange(_FACES) / _FACES
    for end in ends:
        node = np.flatnonzero(end.inside(s) & (s != end.s_end) & (s != end.s))
        across = np.column_stack([np.cos(angles), np.sin(angles)]) @ null_space(end.outward[None]).T
        faces = across - np.tan(_AT_NODES * _HALF_ANGLE_RAD) * end.outward
        parts.append(
            Walls(np.repeat(node, _FACES), np.tile(faces, (len(node), 1)), np.tile(faces @ end.end[:3], len(node)))
        )
    return Walls(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("node", "normal", "offset")))


def narrow_to(ends: Sequence[StraightEnd], s: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Narrow the bounds (k, 6) of nodes s (k,) within straight ends, which hardly tilt."""
    for end in ends:
        inside = end.inside(s)
        for column in TILT_COLUMNS:
            low[inside, column] = np.maximum(low[inside, column], end.end[column] - _AT_NODES * _TILT_RAD)
            high[inside, column] = np.minimum(high[inside, column], end.end[column] + _AT_NODES * _TILT_RAD)
