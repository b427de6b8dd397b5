"""What a path has to keep between its nodes: the limits of its poses, and what concerns the path as a whole.

Of the path as a whole: det H keeps its sign, the pose does not jump to another branch, the working modes are those of
the route and no more changes than its budget allows, the poses stay in the corridor, and the actuators do not nearly
stop. Straight ends keep to their cones.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.config import Config
from pipeline.limits import Limit, applying, path_limits
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.machine.kinematics import pose_jacobian
from pipeline.machine.working_modes import working_modes
from pipeline.refine.corridor.cells import cells_excess
from pipeline.refine.corridor.cone import StraightEnd, straight_ends
from pipeline.refine.corridor.sides import sides_at
from pipeline.refine.measure import PathSamples, relative_speed
from pipeline.refine.result import Path, directions_of
from pipeline.route.result import Route

_ROUNDING = 1e-9
_LEAST_SPEED = 0.07
"""Least |q'(s)| relative to its mean: where actuators nearly stop the path cannot be timed well."""
_FAR, _UNEXPLAINED, _LEAST_JUMP = 20.0, 0.5, 1e-6
"""A jump is this many usual moves long, velocities leave this share of it unexplained, and it is at least this long
(metres, radians)."""
_MORE_NODES = "Raise refine.nodes."


@dataclass(frozen=True, eq=False)
class Requirement:
    """A property that the whole path has to keep.

    Attributes
    ----------
    what : str
        What a path breaks, with the unit of the amount: "links too close, metres".
    advice : str
        What to change if it does.
    margins : callable
        Computes margins at n samples, negative where the requirement is broken, shape (n, m).
    excess : callable
        Computes by how much each margin is broken, shape (n, m).
    rounding : float
        How far below zero a margin still counts as rounding.
    continuous : bool
        Whether margins are continuous along the path, so that they can be bounded between two samples.
    counts : callable
        Tells which margins count at n samples, shape (n, m).
    """

    what: str
    advice: str
    margins: Callable[[PathSamples], FloatArray]
    excess: Callable[[PathSamples], FloatArray]
    rounding: float
    continuous: bool = True
    counts: Callable[[PathSamples], BoolArray] = lambda samples: np.ones((len(samples), 1), dtype=bool)


def path_requirements(config: Config, route: Route, path: Path, coarse: Path) -> list[Requirement]:
    """List everything that a path along a route has to keep, in the order in which it is reported."""
    left_out = _events(
        "an arm leaves out working modes of the route",
        _MORE_NODES,
        lambda samples: lost_modes(route, coarse, samples),
    )
    return [left_out, *own_requirements(config, path), *_of_the_route(config, route, path, coarse)]


def own_requirements(config: Config, path: Path) -> list[Requirement]:
    """List what a path has to keep whatever its route: its branch, the budget of working modes, and all limits."""
    limits = [_of_limit(path, limit) for limit in path_limits(config, path.machine)]
    return [*_of_the_course(config, path), *limits]


def _of_limit(path: Path, limit: Limit) -> Requirement:
    """Require a limit, with the directions in which the path moves the actuators."""
    return Requirement(
        limit.wording.broken_path,
        limit.wording.path_advice,
        limit.margins,
        limit.excess,
        limit.rounding,
        counts=lambda samples: applying(limit, directions_of(path.q(samples.s, 1))),
    )


def _of_the_course(config: Config, path: Path) -> list[Requirement]:
    """List what a path breaks at single samples, with nothing to interpolate between them."""
    return [
        _events("det H changes sign", _MORE_NODES, lambda samples: sign_changes(samples.det_sign)),
        _events("the pose jumps", _MORE_NODES, lambda samples: jumps(path, samples)),
        _events(
            "working modes change more often than task.budget.mode_changes allows",
            "Raise task.budget.mode_changes or refine.nodes.",
            lambda samples: excessive_mode_changes(config.task.budget.mode_changes, samples),
        ),
    ]


def _of_the_route(config: Config, route: Route, path: Path, coarse: Path) -> list[Requirement]:
    """List where along its route a path has to be, and that it moves on; where s is time, it may stand still."""
    corridor = _bounded(
        "outside the corridor, grid steps",
        "Raise refine.nodes or refine.corridor_cells.",
        lambda samples: cells_excess(config, route, coarse, samples.s, samples.pose),
    )

    def side_of(arm: int) -> Requirement:
        what = f"arm {arm + 1} on the side that is another working mode, metres"
        return _bounded(what, _MORE_NODES, lambda samples: wrong_side(route, coarse, samples)[:, arm])

    straight = [_straight(end) for end in straight_ends(config, route, coarse)]
    speed = _bounded(
        "the actuators nearly stop, relative to the mean speed",
        "Raise refine.corridor_cells or refine.nodes, or change refine.coefficients.",
        lambda samples: _LEAST_SPEED - relative_speed(path, samples.s),
    )
    corridors = [] if config.refine.corridor == "free" else [corridor]
    return [*corridors, *map(side_of, range(3)), *straight, *([speed] if path.motion_s is None else [])]


def _straight(end: StraightEnd) -> Requirement:
    """Require the cone of a straight end, and hardly any tilt."""
    return Requirement(
        f"off the straight line at the {end.name}, by more than 3 degrees (metres) or tilted by more than 1 (radians)",
        f"Raise refine.nodes, or change refine.approach_m or refine.{end.name}_direction.",
        lambda samples: -end.excess(samples.pose),
        lambda samples: end.excess(samples.pose),
        _ROUNDING,
        counts=lambda samples: end.inside(samples.s)[:, None],
    )


def _bounded(what: str, advice: str, excess: Callable[[PathSamples], FloatArray]) -> Requirement:
    return Requirement(
        what, advice, lambda samples: -excess(samples)[:, None], lambda samples: excess(samples)[:, None], _ROUNDING
    )


def _events(what: str, advice: str, excess: Callable[[PathSamples], FloatArray]) -> Requirement:
    return replace(_bounded(what, advice, excess), continuous=False)


def sign_changes(sign: FloatArray) -> FloatArray:
    """Mark with one where a sign (n,) differs from the one before or is zero. Shape (n,)."""
    return np.asarray((np.diff(sign, prepend=sign[:1]) != 0.0) | (sign == 0.0), dtype=float)


def jumps(path: Path, samples: PathSamples) -> FloatArray:
    """Measure moves between neighbouring samples, far beyond the usual, that their velocities do not explain.

    They lead to another branch. A move along one branch is the mean of the velocities at both ends times the step, but
    for its third order, however fast a coordinate changes that the speed along s does not count (ry). Shape (n,), zero
    where there is no jump from the sample before.
    """
    step, rates = np.diff(samples.s), pose_jacobian(path.machine, samples.pose, samples.q_m)
    rate = (rates @ path.q(samples.s, 1)[..., None])[..., 0]
    moves = np.diff(samples.pose, axis=0)
    size = np.abs(moves).max(axis=1)
    missed = np.abs(moves - (rate[1:] + rate[:-1]) / 2.0 * step[:, None]).max(axis=1)
    far = size > _FAR * np.median(size / step) * step
    return np.append(0.0, np.where(far & (missed > _UNEXPLAINED * size) & (size > _LEAST_JUMP), size, 0.0))


def wrong_side(route: Route, coarse: Path, samples: PathSamples) -> FloatArray:
    """Compute how far every cart is on the wrong side of its platform joint, -1 where its arm is free. Shape (n, 3)."""
    sides = sides_at(route, coarse, samples.s)
    return np.where(sides == 0.0, -1.0, -sides * samples.reach_m)


def lost_modes(route: Route, coarse: Path, samples: PathSamples) -> FloatArray:
    """Mark with one where an arm may change its working mode that does so less often than on the route. Shape (n,)."""
    fewer = _changes(working_modes(samples.reach_m)) < _changes(MODE_SIGNS[route.modes])
    free = sides_at(route, coarse, samples.s)[:, fewer] == 0.0
    return np.asarray(free.any(axis=1), dtype=float)


def excessive_mode_changes(budget: int | None, samples: PathSamples) -> FloatArray:
    """Mark with one where an arm changes its working mode, if that happens more often than the budget. Shape (n,)."""
    modes = working_modes(samples.reach_m)
    if budget is None or _changes(modes).sum() <= budget:
        return np.zeros(len(modes))
    return np.asarray((np.diff(modes, axis=0, prepend=modes[:1]) != 0.0).any(axis=1), dtype=float)


def _changes(modes: FloatArray) -> IntArray:
    """Count how often each arm changes along modes (n, 3). Shape (3,)."""
    return np.asarray(np.count_nonzero(np.diff(modes, axis=0), axis=0))
