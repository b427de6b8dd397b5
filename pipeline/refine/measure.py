"""Samples of a path and the figures they are reduced to, the same way for the coarse and the refined path."""

import itertools
from dataclasses import dataclass

import numpy as np

from pipeline.arguments import require_array
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.limits import measures
from pipeline.machine.samples import PoseSamples
from pipeline.machine.working_modes import mode_sequence, working_modes
from pipeline.refine.result import Path
from pipeline.route.metric import arc_length

_SPEED_SAMPLES = 1_001
_NO_DISTANCE_M = 1e-9
"""Distance between start and goal, in actuator space, that is rounding."""


@dataclass(frozen=True, eq=False)
class PathSamples(PoseSamples):
    """The machine at samples of a path.

    Attributes
    ----------
    s : (n,)
        Path parameter.
    """

    s: FloatArray


@dataclass(frozen=True)
class KappaFigures:
    """What the objectives of stage two know of a path: its largest kappa, and the integral over its length."""

    kappa_max: float
    kappa_integral: float


@dataclass(frozen=True)
class PathFigures:
    """A path in numbers; lengths and integrals in the metric of the route, working modes in their order.

    `measures` holds the figures of `limits.measures`, by their keys; `actuator_length_m` and `actuator_distance_m` are
    the length of the path in actuator space, Euclidean, and that of the straight line between its ends.
    """

    kappa_max: float
    kappa_max_s: float
    kappa_integral: float
    length: float
    closure_residual_m: float
    measures: dict[str, float]
    det_sign_constant: bool
    modes: tuple[str, ...]
    actuator_length_m: float
    actuator_distance_m: float

    @property
    def length_ratio(self) -> float | None:
        """Length in actuator space against the straight line; None if the goal is the start."""
        distance = self.actuator_distance_m
        return self.actuator_length_m / distance if distance > _NO_DISTANCE_M else None

    @property
    def mode_changes(self) -> int:
        """How many arms change their working mode, counted each time."""
        return sum(a != b for one, other in itertools.pairwise(self.modes) for a, b in zip(one, other, strict=True))


def sample_path(path: Path, s: FloatArray) -> PathSamples:
    """Evaluate a path at s (n,) in [0, 1].

    Raises
    ------
    ArgumentError
        If s has another shape, or is outside [0, 1].
    ForwardKinematicsError
        If the closure equations have no solution near the path.
    """
    s = require_array("s", s, ("n",))
    return PathSamples(path.machine, path.pose(s), path.q(s), s)


def merge_samples(samples: PathSamples, more: PathSamples) -> PathSamples:
    """Merge samples of one path in the order of s; quantities known of the first are computed for the others, too."""
    order = np.argsort(np.concatenate([samples.s, more.s]), kind="stable")
    # Fields and cached quantities alike.
    values = {
        name: np.concatenate([getattr(samples, name), getattr(more, name)])[order]
        for name in vars(samples)
        if name != "machine"
    }
    poses = PathSamples(samples.machine, *(values.pop(name) for name in ("pose", "q_m", "s")))
    return poses.with_known(**values)


def relative_speed(path: Path, s: FloatArray) -> FloatArray:
    """Compute |q'(s)| at s (n,) relative to its mean along the path. Shape (n,)."""
    mean = np.linalg.norm(path.q(np.linspace(0.0, 1.0, _SPEED_SAMPLES), 1), axis=1).mean()
    return np.asarray(np.linalg.norm(path.q(s, 1), axis=1) / mean, dtype=float)


def kappa_trapezoids(kappa: FloatArray, distances: FloatArray) -> FloatArray:
    """Integrate kappa (n,) between neighbouring samples that are `distances` (n - 1,) apart. Shape (n - 1,).

    Trapezoidal rule: (kappa_k + kappa_k+1) / 2 times the distance; the sum is the integral over the length.
    """
    return distances * (kappa[1:] + kappa[:-1]) / 2.0


def measure_kappa(samples: PathSamples, steps: FloatArray) -> KappaFigures:
    """Reduce samples to kappa alone; `steps` (5,) are the largest moves per step of x, y, z, rx, rz."""
    distances = np.diff(arc_length(samples.pose, steps))
    return KappaFigures(float(samples.kappa.max()), float(kappa_trapezoids(samples.kappa, distances).sum()))


def measure_path(samples: PathSamples, steps: FloatArray) -> PathFigures:
    """Reduce samples to figures; `steps` (5,) are the largest moves per step of x, y, z, rx, rz.

    The integral of kappa over the length is the trapezoidal rule on the samples.

    Raises
    ------
    ArgumentError
        If there are fewer than two samples, or a step is not positive.
    """
    steps = require_array("steps", steps, (5,), least=np.nextafter(0.0, 1.0))
    if len(samples) < 2:
        raise ArgumentError(f"samples: expected at least two, not {len(samples)}")
    length = arc_length(samples.pose, steps)
    worst = int(np.argmax(samples.kappa))
    return PathFigures(
        kappa_max=float(samples.kappa[worst]),
        kappa_max_s=float(samples.s[worst]),
        kappa_integral=float(kappa_trapezoids(samples.kappa, np.diff(length)).sum()),
        length=float(length[-1]),
        closure_residual_m=float(samples.closure_residual_m.max()),
        measures={measure.key: measure.reduce(samples) for measure in measures() if measure.applies(samples.machine)},
        det_sign_constant=bool(np.all(samples.det_sign == samples.det_sign[0]) and samples.det_sign[0] != 0.0),
        modes=tuple(mode_sequence(working_modes(samples.reach_m))),
        actuator_length_m=float(np.linalg.norm(np.diff(samples.q_m, axis=0), axis=1).sum()),
        actuator_distance_m=float(np.linalg.norm(samples.q_m[-1] - samples.q_m[0])),
    )
