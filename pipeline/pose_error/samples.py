"""Errors of the tool at samples: what the proven bound is compared with.

Where actuators alone are off, every corner of their errors is tried. Where the geometry is off, too, the worst corner
is climbed to: with G the derivative of the position by all errors, u <- G sign(G' u) never lowers |u' G|_1 of a unit u.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pipeline.arguments import require_array, require_whole
from pipeline.arrays import FloatArray, IntArray
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ACTUATORS, Machine, rotation
from pipeline.machine.kinematics import newton
from pipeline.refine.result import Path

_JOINTS, _RAILS, _LENGTHS = 18, 6, 6
_PROBE_M = 1e-6
_CLIMBS = 4
_SEED = 1


@dataclass(frozen=True, eq=False)
class SampledError:
    """The largest error of the tool that was found at each of n values of s: distance and angle, (n,) each."""

    s: FloatArray
    position_m: FloatArray
    rotation_rad: FloatArray


def sample_pose_error(path: Path, uncertainty: Uncertainty, s: FloatArray, draws: int = 8) -> SampledError:
    """Search the largest error of the tool at each s (n,): at the worst corners, and at `draws` random ones.

    Raises
    ------
    ArgumentError
        If s is not (n,) from 0 to 1, or draws is not 0 to 100,000.
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    s = require_array("s", s, ("n",), least=0.0, largest=1.0)
    draws = require_whole("draws", draws, 0, 100_000)
    nominal, q = path.pose(s), path.q(s)
    position, rotation_rad = np.zeros(len(s)), np.zeros(len(s))
    for errors in _corners(path.machine, uncertainty, (nominal, q), draws):
        pose = _moved(path.machine, errors, nominal, q)
        position = np.maximum(position, np.linalg.norm(pose[:, :3] - nominal[:, :3], axis=1))
        rotation_rad = np.maximum(rotation_rad, rotation_angle(nominal, pose))
    return SampledError(s, position, rotation_rad)


def rotation_angle(one: FloatArray, other: FloatArray) -> FloatArray:
    """Compute the angle (n,) between the orientations of poses (n, 6)."""
    between = rotation(*other.T[3:]) - rotation(*one.T[3:])
    # |R' - R| in the Frobenius norm is sqrt(8) sin(angle / 2), which is exact for small angles, too.
    return np.asarray(2.0 * np.arcsin((np.linalg.norm(between, axis=(1, 2)) / np.sqrt(8.0)).clip(max=1.0)))


def _corners(
    machine: Machine, uncertainty: Uncertainty, at: tuple[FloatArray, FloatArray], draws: int
) -> Iterator[FloatArray]:
    """Give corners of all errors, (n, 53): the worst ones, and random ones."""
    n, sizes = len(at[0]), _sizes(uncertainty)
    free = np.flatnonzero(sizes)
    if len(free) <= len(ACTUATORS):
        for corner in product((-1.0, 1.0), repeat=len(free)):
            yield np.tile(_spread(free, np.array(corner) * sizes[free]), (n, 1))
        return
    random = np.random.default_rng(_SEED)
    for rows in np.split(_derivative(machine, sizes, at), 2, axis=1):
        for axis in np.eye(3):
            u = np.tile(axis, (n, 1))
            for _ in range(_CLIMBS):
                signs = np.where(np.einsum("nij,ni->nj", rows, u) < 0.0, -1.0, 1.0)
                u = np.einsum("nij,nj->ni", rows, signs)
                u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-300)
            yield from (signs * sizes, -signs * sizes)
    for _ in range(draws):
        yield random.choice([-1.0, 1.0], (n, len(sizes))) * sizes


def _sizes(uncertainty: Uncertainty) -> FloatArray:
    """List the sizes (53,): coordinates of joints and rails, lengths of links, actuators."""
    coordinates = np.full(2 * _JOINTS + _RAILS, uncertainty.coordinate_m)
    return np.concatenate([coordinates, np.full(_LENGTHS, uncertainty.length_m), uncertainty.actuator_m])


def _spread(free: IntArray, values: FloatArray) -> FloatArray:
    errors = np.zeros(2 * _JOINTS + _RAILS + _LENGTHS + len(ACTUATORS))
    errors[free] = values
    return errors


def _derivative(machine: Machine, sizes: FloatArray, at: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Differentiate position and orientation by errors of their sizes, by central differences. Shape (n, 6, 53)."""
    columns = []
    for k, size in enumerate(sizes):
        if size == 0.0:
            columns.append(np.zeros((len(at[0]), 6)))
            continue
        step = _spread(np.array([k]), np.array([_PROBE_M]))
        ahead, behind = (_moved(machine, np.tile(side * step, (len(at[0]), 1)), *at) for side in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * _PROBE_M) * size)
    return np.stack(columns, axis=2)


def _moved(machine: Machine, errors: FloatArray, nominal: FloatArray, q_m: FloatArray) -> FloatArray:
    """Find the poses (n, 6) of machines with errors (n, 53) near the nominal ones."""
    if (errors == errors[0]).all():
        return newton(_wrong(machine, errors[0]), _actuators(errors, q_m), nominal)[0]
    rows = zip(errors, nominal, _actuators(errors, q_m), strict=True)
    return np.stack([newton(_wrong(machine, error), q[None], pose[None])[0][0] for error, pose, q in rows])


def _wrong(machine: Machine, errors: FloatArray) -> Machine:
    points, offsets, rails, lengths, _ = np.split(errors, np.cumsum([_JOINTS, _JOINTS, _RAILS, _LENGTHS]))
    return replace(
        machine,
        platform_points_m=machine.platform_points_m + points.reshape(6, 3),
        cart_offsets_m=machine.cart_offsets_m + offsets.reshape(6, 3),
        rails_m=machine.rails_m + rails.reshape(3, 2),
        lengths_m=machine.lengths_m + lengths,
    )


def _actuators(errors: FloatArray, q_m: FloatArray) -> FloatArray:
    """Compute where the actuators (n, 5) are; a telescope is off by its length's error, too."""
    telescopes = errors[:, 2 * _JOINTS + _RAILS :][:, [2, 4]]
    return np.asarray(q_m + errors[:, -len(ACTUATORS) :] + np.pad(telescopes, ((0, 0), (3, 0))))
