"""Figures of a path, measured on dense samples: the same way for the coarse and the refined one."""

import itertools
from dataclasses import dataclass, fields

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.clearance import min_distances
from pipeline.machine.kinematics import closure_residual
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.machine.working_modes import mode_sequence, reach_along_rails, working_modes
from pipeline.refine.result import Path
from pipeline.route.metric import arc_length

_TILTS = [3, 5]
_EVENLY = np.linspace(0.0, 1.0, 1_001)


@dataclass(frozen=True, eq=False)
class PathSamples:
    """What the machine does at samples of s.

    Attributes
    ----------
    s : (n,)
        Path parameter.
    pose, q_m : (n, 6), (n, 5)
        x, y, z, rx, ry, rz by forward kinematics; actuator positions.
    kappa, det_sign : (n,)
        Condition number and sign of det H.
    link_distance_m, rail_distance_m : (n,)
        Least link-link and link-rail distance between axes.
    closure_residual_m : (n,)
        Largest amount by which a link misses its length.
    reach_m : (n, 3)
        By how much each cart joint is at larger x than its platform joint: its sign is the working mode.
    """

    s: FloatArray
    pose: FloatArray
    q_m: FloatArray
    kappa: FloatArray
    det_sign: FloatArray
    link_distance_m: FloatArray
    rail_distance_m: FloatArray
    closure_residual_m: FloatArray
    reach_m: FloatArray


@dataclass(frozen=True)
class PathFigures:
    """A path in numbers; lengths and integrals in the metric of the route, working modes in their order."""

    kappa_max: float
    kappa_max_s: float
    kappa_integral: float
    length: float
    closure_residual_m: float
    min_link_distance_m: float
    min_rail_distance_m: float
    max_tilt_deg: float
    det_sign_constant: bool
    modes: tuple[str, ...]

    @property
    def mode_changes(self) -> int:
        """How many arms change their working mode, counted each time."""
        return sum(a != b for one, other in itertools.pairwise(self.modes) for a, b in zip(one, other, strict=True))


def sample_path(path: Path, s: FloatArray) -> PathSamples:
    """Evaluate a path at s (n,).

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path.
    """
    q, pose = path.q(s), path.pose(s)
    H = statics_matrix(path.machine, pose, q[:, :3])
    link_distance, rail_distance = min_distances(path.machine, pose, q[:, :3])
    return PathSamples(
        s=s,
        pose=pose,
        q_m=q,
        kappa=condition_number(H),
        det_sign=det_sign(H),
        link_distance_m=link_distance,
        rail_distance_m=rail_distance,
        closure_residual_m=np.abs(closure_residual(path.machine, pose, q)).max(axis=1),
        reach_m=reach_along_rails(path.machine, pose, q[:, :3]),
    )


def relative_speed(path: Path, s: FloatArray) -> FloatArray:
    """|q'(s)| at s (n,) relative to its mean along the path: near zero the path cannot be timed. Shape (n,)."""
    mean = np.linalg.norm(path.q(_EVENLY, 1), axis=1).mean()
    relative: FloatArray = np.linalg.norm(path.q(s, 1), axis=1) / mean
    return relative


def merged(samples: PathSamples, more: PathSamples) -> PathSamples:
    """Put samples of one path together, in the order of s."""
    order = np.argsort(np.concatenate([samples.s, more.s]), kind="stable")
    columns = {
        field.name: np.concatenate([getattr(samples, field.name), getattr(more, field.name)])[order]
        for field in fields(PathSamples)
    }
    return PathSamples(**columns)


def measure_path(samples: PathSamples, steps: FloatArray) -> PathFigures:
    """Reduce samples to figures; `steps` (5,) are the largest moves per step of x, y, z, rx, rz.

    The integral of kappa over the length is the trapezoidal rule on the samples.
    """
    length = arc_length(samples.pose, steps)
    worst = int(np.argmax(samples.kappa))
    return PathFigures(
        kappa_max=float(samples.kappa[worst]),
        kappa_max_s=float(samples.s[worst]),
        kappa_integral=float(np.trapezoid(samples.kappa, length)),
        length=float(length[-1]),
        closure_residual_m=float(samples.closure_residual_m.max()),
        min_link_distance_m=float(samples.link_distance_m.min()),
        min_rail_distance_m=float(samples.rail_distance_m.min()),
        max_tilt_deg=float(np.rad2deg(np.abs(samples.pose[:, _TILTS]).max())),
        det_sign_constant=bool(np.all(samples.det_sign == samples.det_sign[0]) and samples.det_sign[0] != 0.0),
        modes=tuple(mode_sequence(working_modes(samples.reach_m))),
    )
