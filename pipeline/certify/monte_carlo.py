"""The least calibration error at which a sampled machine fails, for comparison with the proven tolerance.

Machines are drawn with an error of plus or minus eps in every uncertain parameter. The first is the likely worst: to
first order it lowers det H fastest where kappa is largest. Each is followed along the path from eps = 0 on.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.refine.result import Path

_SAMPLES = 400
_STEPS = 24
_HALVINGS = 6
_LARGEST_M = 0.05
_MISS_M = 1e-9
_PROBE_M = 1e-6
_SEED = 1


@dataclass(frozen=True, eq=False)
class _Errors:
    """Signs -1, 0 or 1 of the errors of a machine: joints, rails, link lengths (telescopes included)."""

    points: FloatArray
    offsets: FloatArray
    rails: FloatArray
    lengths: FloatArray

    @classmethod
    def from_signs(cls, signs: FloatArray) -> "_Errors":
        """Split a vector (48,) into 18 and 18 joint coordinates, 6 of rails and 6 lengths."""
        points, offsets, rails, lengths = np.split(signs, [18, 36, 42])
        return cls(points.reshape(6, 3), offsets.reshape(6, 3), rails.reshape(3, 2), lengths)

    def applied(self, machine: Machine, eps: float) -> Machine:
        """Return the machine with errors of size eps."""
        return replace(
            machine,
            platform_points_m=machine.platform_points_m + eps * self.points,
            cart_offsets_m=machine.cart_offsets_m + eps * self.offsets,
            rails_m=machine.rails_m + eps * self.rails,
            lengths_m=machine.lengths_m + eps * self.lengths,
        )

    def actuators(self, q_m: FloatArray, eps: float) -> FloatArray:
        """Compute the true positions of carts and telescopes."""
        return q_m + eps * np.concatenate([np.zeros(3), self.lengths[[2, 4]]])


def failing_eps(machine: Machine, path: Path, kind: Callable[[float], Uncertainty], samples: int) -> float:
    """Return the least eps in metres at which a sampled machine cannot follow the path; infinite if all can."""
    s = np.linspace(0.0, 1.0, _SAMPLES)
    pose, q = path.pose(s), path.q(s)
    lengths_only = kind(1.0).coordinate_m == 0.0
    free = np.concatenate([np.full(42, not lengths_only), np.full(6, True)])
    random = np.random.default_rng(_SEED)
    worst = _steepest(machine, pose, q, free)
    draws = [worst, -worst] + [random.choice([-1.0, 1.0], 48) * free for _ in range(samples)]
    least = _LARGEST_M
    found = np.inf
    for signs in draws:
        failed = _first_failure(machine, _Errors.from_signs(signs), pose, q, least)
        if failed < least:
            least = found = failed
    return float(found)


def _first_failure(machine: Machine, errors: _Errors, nominal: FloatArray, q_m: FloatArray, most: float) -> float:
    """Follow a machine from eps = 0 to `most`, halving the step if it fails; infinite if it never does."""
    sign = np.sign(np.linalg.det(statics_matrix(machine, nominal, q_m[:, :3])))
    eps, step, pose, halvings = 0.0, most / _STEPS, nominal, 0
    while eps < most:
        wrong = errors.applied(machine, eps + step)
        actuators = errors.actuators(q_m, eps + step)
        moved, miss = newton(wrong, actuators, pose)
        held = np.sign(np.linalg.det(statics_matrix(wrong, moved, actuators[:, :3]))) == sign
        if (miss <= _MISS_M).all() and held.all():
            eps, pose = eps + step, moved
        elif halvings == _HALVINGS:
            return eps + step
        else:
            step, halvings = step / 2.0, halvings + 1
    return np.inf


def _steepest(machine: Machine, pose: FloatArray, q_m: FloatArray, free: FloatArray) -> FloatArray:
    """Return the signs (48,) that lower |det H| fastest at the pose with the largest kappa."""
    row = [int(np.argmax(condition_number(statics_matrix(machine, pose, q_m[:, :3]))))]
    signs = np.zeros(48)
    for k in np.flatnonzero(free):
        size = []
        for side in (-1.0, 1.0):
            errors = _Errors.from_signs(side * np.eye(48)[k])
            wrong, actuators = errors.applied(machine, _PROBE_M), errors.actuators(q_m[row], _PROBE_M)
            moved, _ = newton(wrong, actuators, pose[row])
            size.append(abs(float(np.linalg.det(statics_matrix(wrong, moved, actuators[:, :3]))[0])))
        signs[k] = -1.0 if size[1] > size[0] else 1.0
    return signs
