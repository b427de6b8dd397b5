"""Paths that cannot be timed at all: refused before any planning, with the place and the limit that prevents it."""

import numpy as np

from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine.result import Path
from pipeline.retime.holding_forces import pose_words

_LEAST_RELATIVE_SPEED = 0.05
"""Least |q'(s)| relative to its mean, in metres: a property of the path alone, whatever its limits. Below, the path
speed peaks too sharply for a piecewise constant path acceleration: on lines of known duration and 1,000 grid points,
0.02 came out up to 80 % too slow and 14 % above an acceleration limit."""
_LEAST_TRAVEL_M = 1e-9
_CHECK_POINTS = 20_001
"""Values of s at which the speed |q'(s)| is evaluated."""


def require_smooth(path: Path) -> None:
    """Refuse a spline whose first or second derivative jumps: it can only be driven by stopping there.

    Raises
    ------
    NoSolutionError
        With the place of the first corner.
    """
    degree, knots = path.spline.k, path.spline.t
    interior, counts = np.unique(knots[degree + 1 : -degree - 1], return_counts=True)
    rough = interior[degree - counts < 2]
    if rough.size:
        raise NoSolutionError(
            "retime",
            f"the path's velocity or curvature jumps at s = {rough[0]:.4f}",
            "Time a refined path: splines of degree 3 or more with simple knots.",
            {"s": float(rough[0])},
        )


def require_motion(path: Path) -> None:
    """Refuse a path that does not move, that needs a locked actuator, or that nearly stops somewhere.

    A path that comes with a time law may stop.

    Raises
    ------
    NoSolutionError
        With the place, and the limit if it is one.
    """
    s = np.linspace(0.0, 1.0, _CHECK_POINTS)
    travel = np.ptp(path.q(s), axis=0)
    if travel.max() < _LEAST_TRAVEL_M:
        raise NoSolutionError(
            "retime",
            "the path does not move: no actuator travels",
            "Give the task a goal that differs from its start.",
        )
    require_locked_at_rest(path)
    if path.motion_s is not None:
        return
    speed = np.linalg.norm(path.q(s, 1), axis=1)
    relative = speed / speed.mean()
    slowest = int(np.argmin(relative))
    if not relative[slowest] >= _LEAST_RELATIVE_SPEED:
        raise NoSolutionError(
            "retime",
            f"the path nearly stops at s = {s[slowest]:.4f}: |q'(s)| falls to {relative[slowest]:.2%} of its mean, but "
            f"accurate timing needs at least {_LEAST_RELATIVE_SPEED:.0%}",
            "Refine with other refine.coefficients or refine.corridor_cells, so that s stays close to arc length.",
            {"s": float(s[slowest]), "relative_speed": float(relative[slowest])},
        )


def require_locked_at_rest(path: Path) -> None:
    """Refuse a path that needs a locked actuator: a spline is between its least and its largest coefficient.

    Raises
    ------
    NoSolutionError
        With the actuator, and the place where it begins to move.
    """
    travel = np.ptp(path.spline.c, axis=0)
    for locked in np.flatnonzero((path.machine.velocity_mps == 0.0) & ~(travel < _LEAST_TRAVEL_M)):
        s = np.linspace(0.0, 1.0, _CHECK_POINTS)
        rates = np.abs(path.q(s, 1)[:, locked])
        place = float(s[np.argmax(rates > 1e-6 * rates.max())])
        raise NoSolutionError(
            "retime",
            f"{ACTUATORS[locked]} has to move from s = {place:.4f} on, at {pose_words(path.pose(place))}, but its "
            "velocity limit is 0 m/s",
            "Raise machine.limits, or give the task a goal that does not need this actuator.",
            {"actuator": ACTUATORS[locked], "limit": "velocity", "s": place},
        )
