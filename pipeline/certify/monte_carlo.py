"""The least error at which a sampled machine fails, for comparison with the proven tolerance.

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

_SAMPLES = 200
_DRAWS_FOLLOWING = 6
_STEPS = 10
_HALVINGS = 7
_LARGEST_M = 0.05
_LARGEST_FOLLOWING_M = 0.3
_MISS_M = 1e-9
_NEAR = 0.3
"""Metres and radians that a pose moves by at most from step to step: farther away Newton's method may change branch."""
_PROBE_M = 1e-6
_SEED = 1


@dataclass(frozen=True, eq=False)
class _Errors:
    """Errors of a machine relative to eps: joints, rails, link lengths (telescopes included), actuators."""

    points: FloatArray
    offsets: FloatArray
    rails: FloatArray
    lengths: FloatArray
    drives: FloatArray

    @classmethod
    def from_signs(cls, signs: FloatArray) -> "_Errors":
        """Split a vector (53,) into 18 and 18 joint coordinates, 6 of rails, 6 lengths and 5 actuators."""
        points, offsets, rails, lengths, drives = np.split(signs, [18, 36, 42, 48])
        return cls(points.reshape(6, 3), offsets.reshape(6, 3), rails.reshape(3, 2), lengths, drives)

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
        return q_m + eps * (np.concatenate([np.zeros(3), self.lengths[[2, 4]]]) + self.drives)


def failing_eps(machine: Machine, path: Path, kind: Callable[[float], Uncertainty], samples: int) -> float:
    """Return the least eps in metres at which a sampled machine cannot follow the path; infinite if all can."""
    unit = kind(1.0)
    s = np.linspace(0.0, 1.0, _SAMPLES)
    pose, q = path.pose(s), path.q(s)
    free = np.concatenate([np.full(42, unit.coordinate_m), np.full(6, unit.length_m), unit.actuator_m])
    # Errors of actuators may be larger before a machine fails, and have few combinations.
    largest, steps, most = (_LARGEST_M, _STEPS, samples)
    if any(unit.actuator_m):
        largest, most = _LARGEST_FOLLOWING_M, min(_DRAWS_FOLLOWING, (1 << int(np.count_nonzero(free))) - 2)
    random = np.random.default_rng(_SEED)
    worst = _steepest(machine, pose, q, free)
    draws = [worst, -worst] + [random.choice([-1.0, 1.0], len(free)) * free for _ in range(min(samples, most))]
    least = largest
    found = np.inf
    for signs in draws:
        failed = _first_failure(machine, _Errors.from_signs(signs), (pose, q), (least, least / steps))
        if failed < least:
            least = found = failed
    return float(found)


def _first_failure(
    machine: Machine, errors: _Errors, motion: tuple[FloatArray, FloatArray], reach: tuple[float, float]
) -> float:
    """Follow a machine along poses and actuators from eps = 0 to the first of `reach`, infinite if it never fails.

    By steps of the second, halved where it fails.
    """
    (nominal, q_m), (most, step) = motion, reach
    sign = np.sign(np.linalg.det(statics_matrix(machine, nominal, q_m[:, :3])))
    eps, pose, per_m, halvings = 0.0, nominal, np.zeros_like(nominal), 0
    while eps < most:
        wrong = errors.applied(machine, eps + step)
        actuators = errors.actuators(q_m, eps + step)
        moved, miss = newton(wrong, actuators, pose + step * per_m)
        held = np.sign(np.linalg.det(statics_matrix(wrong, moved, actuators[:, :3]))) == sign
        near = np.abs(moved - pose).max() <= _NEAR
        if (miss <= _MISS_M).all() and held.all() and near:
            eps, pose, per_m = eps + step, moved, (moved - pose) / step
        elif halvings == _HALVINGS:
            return eps + step
        else:
            step, halvings = step / 2.0, halvings + 1
    return np.inf


def _steepest(machine: Machine, pose: FloatArray, q_m: FloatArray, free: FloatArray) -> FloatArray:
    """Return the errors (53,), of the sizes `free`, that lower |det H| fastest at the pose with the largest kappa."""
    row = [int(np.argmax(condition_number(statics_matrix(machine, pose, q_m[:, :3]))))]
    signs, unit = np.zeros(len(free)), np.eye(len(free))
    for k in np.flatnonzero(free):
        size = []
        for side in (-1.0, 1.0):
            errors = _Errors.from_signs(side * unit[k])
            wrong, actuators = errors.applied(machine, _PROBE_M), errors.actuators(q_m[row], _PROBE_M)
            moved, _ = newton(wrong, actuators, pose[row])
            size.append(abs(float(np.linalg.det(statics_matrix(wrong, moved, actuators[:, :3]))[0])))
        signs[k] = -free[k] if size[1] > size[0] else free[k]
    return signs
