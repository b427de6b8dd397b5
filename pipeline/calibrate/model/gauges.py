"""What no measurement of reflectors can tell: changes of the machine that change nothing that is seen.

Whatever the poses,

- nine: rail y, z and cart zero of each arm against the offsets of its cart joints;
- six: the machine's frame against the tracker's (four where the directions of rails are not fitted);
- six: the platform's frame against the reflectors;
- two, where links 3a and 3c share their cart joint: platform joints may slide along the line 3a-3c with the lengths
  adapted, as all its points are at constant distances from that joint.

The prior settles them by convention: the datum is the machine as configured.
"""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.model import parameters as kinds
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import FIXED
from pipeline.machine.geometry import ARM_OF_LINK, PRIMARY, TRIANGLE

_RANK = 1e-9
"""Singular values below this part of the largest are zero."""
_ARM3 = PRIMARY[2]


def gauges(model: Model) -> FloatArray:
    """Give the changes of all parameters that change nothing that is seen, a row each. Shape (gauges, count)."""
    rows = [*_of_carts(model), *_of_the_machine(model), *_of_the_platform(model), *_of_the_triangle(model)]
    return np.array(rows)


def fitted_gauges(model: Model, is_fitted: BoolArray) -> FloatArray:
    """Combine those changes that leave what is not fitted as it is. Shape (gauges, count), orthonormal rows."""
    return _leaving(gauges(model), is_fitted)


def fitted_frames(model: Model, is_fitted: BoolArray) -> FloatArray:
    """Combine those of the gauges that merely choose frames, for the machine and its platform. (frames, count).

    They turn and shift all that is on the machine, rails and joints alike, so that nothing changes but the numbers.
    """
    return _leaving(np.array([*_frame_of_the_machine(model), *_of_the_platform(model)]), is_fitted)


def _leaving(rows: FloatArray, is_fitted: BoolArray) -> FloatArray:
    """Combine changes (n, count) to those that leave what is not fitted as it is, with orthonormal rows."""
    fixed = rows[:, ~is_fitted]
    if fixed.size:
        U, s, _ = np.linalg.svd(fixed)
        rows = U[:, np.count_nonzero(s > _RANK) :].T @ rows
    return np.asarray(np.linalg.qr(rows.T)[0].T)


def rank(jacobian: FloatArray) -> int:
    """Count the directions in which the data change at all, for a Jacobian (m, fitted) in units of the prior."""
    s = np.linalg.svd(jacobian, compute_uv=False)
    return int(np.count_nonzero(s > _RANK * s.max(initial=0.0)))


def _of_carts(model: Model) -> Iterator[FloatArray]:
    for arm in range(3):
        for axis in range(3):
            row = _Row(model)
            row.offsets[arm == ARM_OF_LINK, axis] = -1.0
            if axis:
                row.rails[arm, axis - 1] = 1.0
            else:
                # Where carts go on, rails that rise do, too.
                row.zeros[arm] = 1.0
                row.rails[arm] = -model.directions_rad[arm]
            yield row.theta


def _of_the_machine(model: Model) -> Iterator[FloatArray]:
    place = model.cart_offsets_m + np.column_stack([model.middles_m[:3], model.rails_m])[ARM_OF_LINK]
    for axis in range(3):
        row = _Row(model)
        row.offsets[:, axis] = 1.0
        row.tracker[3:] = -model.rotation[:, axis]
        yield row.theta
    for axis in range(3):
        row, turn = _Row(model), np.eye(3)[axis]
        row.offsets[:] = np.cross(turn, place)
        # (x - m) d turns by (x - m) turn x d: by its x carts go farther, and less is left to the slopes.
        moved = np.cross(turn, np.column_stack([np.ones(3), model.directions_rad]))
        row.directions[:] = moved[:, 1:] - moved[:, :1] * model.directions_rad
        row.zeros[:3] = moved[:, 0] * model.zeros_m[:3]
        row.scales[:3] = moved[:, 0] * model.scales[:3]
        row.tracker[:3] = -model.rotation @ turn
        yield row.theta


def _frame_of_the_machine(model: Model) -> Iterator[FloatArray]:
    origins = np.column_stack([model.middles_m[:3], model.rails_m])
    for axis in range(3):
        row = _Row(model)
        if axis:
            row.rails[:, axis - 1] = 1.0
        else:
            row.zeros[:3] = 1.0
            row.rails[:] = -model.directions_rad
        row.tracker[3:] = -model.rotation[:, axis]
        yield row.theta
    for axis in range(3):
        row, turn = _Row(model), np.eye(3)[axis]
        moved = np.cross(turn, origins)
        row.zeros[:3], row.rails[:] = moved[:, 0], moved[:, 1:] - moved[:, :1] * model.directions_rad
        row.offsets[:] = np.cross(turn, model.cart_offsets_m)
        row.directions[:] = np.cross(turn, [1.0, 0.0, 0.0])[1:]
        row.tracker[:3] = -model.rotation @ turn
        yield row.theta


def _of_the_platform(model: Model) -> Iterator[FloatArray]:
    for axis in range(3):
        row = _Row(model)
        row.platform[:, axis] = row.reflectors[:, axis] = 1.0
        yield row.theta
    for axis in range(3):
        row, turn = _Row(model), np.eye(3)[axis]
        row.platform[:] = np.cross(turn, model.platform_points_m)
        row.reflectors[:] = np.cross(turn, model.reflectors_m)
        yield row.theta


def _of_the_triangle(model: Model) -> Iterator[FloatArray]:
    """Slide one of the joints: |g + e R w| changes by e g . R w / |g|, which the closures of the triangle keep."""
    if (model.cart_offsets_m[_ARM3] != model.cart_offsets_m[TRIANGLE]).any():
        return
    side = model.platform_points_m[TRIANGLE] - model.platform_points_m[_ARM3]
    first, third = model.lengths_m[_ARM3], model.lengths_m[TRIANGLE]
    along = (third**2 - first**2 - side @ side) / 2.0
    for link, product in ((_ARM3, along), (TRIANGLE, along + side @ side)):
        row = _Row(model)
        row.platform[link] = side
        row.lengths[list(FIXED).index(link)] = product / model.lengths_m[link]
        yield row.theta


class _Row:
    """Changes of all parameters, with views of their kinds as they are in the model."""

    def __init__(self, model: Model) -> None:
        parameters = model.parameters
        self.theta = np.zeros(parameters.count)
        self.platform = parameters.of(kinds.PLATFORM, self.theta).reshape(6, 3)
        self.offsets = parameters.of(kinds.OFFSETS, self.theta).reshape(6, 3)
        self.rails = parameters.of(kinds.RAILS, self.theta).reshape(3, 2)
        self.lengths = parameters.of(kinds.LENGTHS, self.theta)
        self.zeros = parameters.of(kinds.ZEROS, self.theta)
        self.scales = parameters.of(kinds.SCALES, self.theta)
        self.directions = parameters.of(kinds.DIRECTIONS, self.theta).reshape(3, 2)
        self.reflectors = parameters.of(kinds.REFLECTORS, self.theta).reshape(-1, 3)
        self.tracker = parameters.of(kinds.TRACKER, self.theta)
