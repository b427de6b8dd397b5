"""The check between the nodes: what the program promises at nodes must hold on the whole path.

A limit counts as kept between two samples when the nearer of them stays away from it by more than the excess could
rise in between: half of its second derivative times the squared distance, four times what a parabola needs.
Elsewhere samples are added until that is so.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError
from pipeline.limits.avoid import boxes_to_avoid
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.machine.kinematics import pose_jacobian
from pipeline.machine.working_modes import working_modes
from pipeline.refine.corridor import cells_excess
from pipeline.refine.measure import PathSamples, merged, relative_speed, sample_path
from pipeline.refine.path_limits import TILTS, kappa_cap, tilt_limits_deg
from pipeline.refine.result import Path
from pipeline.refine.sides import sides_at
from pipeline.route.metric import CONTROLLED
from pipeline.route.result import Route

_ROUNDING = 1e-9
_HALVINGS = 12
"""How often an interval between two samples is halved at most; a rise that is left then is below any tolerance."""
_LEAST_SPEED = 0.07
"""Least |q'(s)| relative to its mean: where actuators nearly stand still the path cannot be timed well."""

_FAR, _UNEXPLAINED, _LEAST_JUMP = 20.0, 0.5, 1e-6
"""How far a jump is in usual moves, its share that velocities do not explain, the least one (metres, radians)."""


@dataclass(frozen=True, eq=False)
class Violation:
    """A promise broken somewhere: what, by how much at worst, at which s (n,), and what to change."""

    what: str
    worst: float
    s: FloatArray
    advice: str

    def __str__(self) -> str:
        return f"{self.what} (by {self.worst:.4g} at worst, first at s = {self.s[0]:.4f})"


def find_violations(config: Config, route: Route, path: Path, coarse: Path) -> list[Violation]:
    """Sample a path as densely as it takes and list what it breaks.

    One sign of det H, kappa, clearance, tilt, boxes to avoid, strokes, travel, the corridor with the working modes of
    the route, and speed along s.
    """
    s = np.linspace(0.0, 1.0, config.refine.check_points + 1)
    try:
        samples = sample_path(path, s)
        for _ in range(_HALVINGS):
            s = _doubtful(samples.s, [excess for _, excess, _ in _limits(config, route, path, coarse, samples)])
            if len(s) == 0:
                break
            samples = merged(samples, sample_path(path, s))
    except ForwardKinematicsError as error:
        what = "the closure equations have no solution, links miss their lengths by metres"
        return [Violation(what, error.residual_m, s[[error.index]], "Raise refine.nodes.")]
    return [
        Violation(what, float(excess.max()), samples.s[excess > _ROUNDING], advice)
        for what, excess, advice in _ways(config, route, path, coarse, samples)
        + _limits(config, route, path, coarse, samples)
        if (excess > _ROUNDING).any()
    ]


def _doubtful(s: FloatArray, excesses: list[FloatArray]) -> FloatArray:
    """Middles of the intervals of s (n,) within which an excess (n,) that is kept at both ends may rise above zero."""
    step = np.diff(s)
    doubtful = np.zeros(len(step), dtype=bool)
    for excess in excesses:
        if not np.isfinite(excess).all():
            continue
        slope = np.diff(excess) / step
        bend = np.zeros(len(s))
        bend[1:-1] = 2.0 * np.abs(np.diff(slope)) / (step[1:] + step[:-1])
        bend[[0, -1]] = bend[[1, -2]]
        rise = np.maximum(bend[1:], bend[:-1]) * step**2 / 2.0
        worst = np.maximum(excess[1:], excess[:-1])
        doubtful |= (worst <= _ROUNDING) & (worst + rise > _ROUNDING)
    return (s[:-1] + step / 2.0)[doubtful]


Excess = tuple[str, FloatArray, str]
"""A promise, by how much it is broken at every sample (n,), negative where it is kept, and what would help."""


def _ways(config: Config, route: Route, path: Path, coarse: Path, samples: PathSamples) -> list[Excess]:
    """What is wrong with the way itself."""
    return [
        ("det H changes sign", _sign_changes(samples.det_sign), "Raise refine.nodes."),
        ("the pose jumps", _jumps(path, samples), "Raise refine.nodes."),
        ("an arm leaves out working modes of the route", _lost_modes(route, coarse, samples), "Raise refine.nodes."),
        (
            "working modes change more often than task.budget.mode_changes allows",
            _mode_changes_beyond(config.task.budget.mode_changes, samples),
            "Raise task.budget.mode_changes or refine.nodes.",
        ),
    ]


def _limits(config: Config, route: Route, path: Path, coarse: Path, samples: PathSamples) -> list[Excess]:
    """Limits that hold all along the path."""
    machine, q = path.machine, samples.q_m
    limits = machine.actuator_limits_m
    more_clearance = "Raise refine.clearance_margin_m or refine.nodes."
    return [
        (
            "kappa above its cap",
            samples.kappa - kappa_cap(config),
            "Raise refine.kappa_max, route.kappa_max or refine.corridor_cells.",
        ),
        ("links too close, metres", machine.link_link_m - samples.link_distance_m, more_clearance),
        ("a link too close to a rail, metres", _rail_excess(path, samples), more_clearance),
        (
            "tilt too large, degrees",
            _tilt_excess(config, samples),
            "Raise refine.tilt_margin_deg, refine.nodes or, for a locked axis, refine.lock_tolerance_deg.",
        ),
        *(
            (f"task.avoid[{k}] is entered, metres or radians", box.depth_m(samples.pose[:, CONTROLLED]), more_clearance)
            for k, box in enumerate(boxes_to_avoid(config))
        ),
        (
            "actuators beyond stroke or travel, metres",
            np.maximum(limits[:, 0] - q, q - limits[:, 1]).max(axis=1),
            "Raise refine.nodes.",
        ),
        (
            "outside the corridor, grid steps",
            cells_excess(config, route, coarse, samples.s, samples.pose),
            "Raise refine.nodes or refine.corridor_cells.",
        ),
        *(
            (f"arm {arm} on the side that is another working mode, metres", excess, "Raise refine.nodes.")
            for arm, excess in enumerate(_wrong_side(route, coarse, samples), start=1)
        ),
        (
            "the actuators nearly stop, relative to the mean speed",
            _LEAST_SPEED - relative_speed(path, samples.s),
            "Raise refine.corridor_cells or refine.nodes, or change refine.coefficients.",
        ),
    ]


def _sign_changes(sign: FloatArray) -> FloatArray:
    """One where a sign differs from the one before or is zero, shape (n,)."""
    changes: FloatArray = (np.diff(sign, prepend=sign[:1]) != 0.0) | (sign == 0.0)
    return changes.astype(float)


def _wrong_side(route: Route, coarse: Path, samples: PathSamples) -> FloatArray:
    """How far every cart is on the wrong side of its platform joint, far from it where it is free. Shape (3, n)."""
    sides = sides_at(route, coarse, samples.s)
    excess: FloatArray = np.where(sides == 0.0, -1.0, -sides * samples.reach_m).T
    return excess


def _lost_modes(route: Route, coarse: Path, samples: PathSamples) -> FloatArray:
    """One where an arm may change its working mode that does so less often than on the route, shape (n,)."""
    fewer = _changes(working_modes(samples.reach_m)) < _changes(MODE_SIGNS[route.modes])
    free = sides_at(route, coarse, samples.s)[:, fewer] == 0.0
    found: FloatArray = free.any(axis=1).astype(float)
    return found


def _mode_changes_beyond(budget: int | None, samples: PathSamples) -> FloatArray:
    """One where an arm changes its working mode, if that happens more often than the task allows, shape (n,)."""
    modes = working_modes(samples.reach_m)
    if budget is None or _changes(modes).sum() <= budget:
        return np.zeros(len(modes))
    changes: FloatArray = (np.diff(modes, axis=0, prepend=modes[:1]) != 0.0).any(axis=1).astype(float)
    return changes


def _changes(modes: FloatArray) -> IntArray:
    """How often each arm changes along modes (n, 3)."""
    changes: IntArray = np.count_nonzero(np.diff(modes, axis=0), axis=0)
    return changes


def _rail_excess(path: Path, samples: PathSamples) -> FloatArray:
    if np.isnan(path.machine.link_rail_m):
        return np.full(len(samples.s), -np.inf)
    return path.machine.link_rail_m - samples.rail_distance_m


def _tilt_excess(config: Config, samples: PathSamples) -> FloatArray:
    tilt = np.rad2deg(np.abs(samples.pose[:, [column for _, column in TILTS]]))
    excess: FloatArray = (tilt - tilt_limits_deg(config)).max(axis=1)
    return excess


def _jumps(path: Path, samples: PathSamples) -> FloatArray:
    """Moves between neighbouring samples, far beyond the usual, that their velocities do not explain. Shape (n,).

    They lead to another branch. A move along one branch is the mean of the velocities at both ends times the step, but
    for its third order, however fast a coordinate changes that the speed along s does not count (ry).
    """
    step, rates = np.diff(samples.s), pose_jacobian(path.machine, samples.pose, samples.q_m)
    rate = (rates @ path.q(samples.s, 1)[..., None])[..., 0]
    moves = np.diff(samples.pose, axis=0)
    size = np.abs(moves).max(axis=1)
    missed = np.abs(moves - (rate[1:] + rate[:-1]) / 2.0 * step[:, None]).max(axis=1)
    far = size > _FAR * np.median(size / step) * step
    jumps: FloatArray = np.append(0.0, np.where(far & (missed > _UNEXPLAINED * size) & (size > _LEAST_JUMP), size, 0.0))
    return jumps
