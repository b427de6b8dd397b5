"""What a tracker sees of a machine whose encoders show q, and how that changes with every parameter.

The pose follows from the closures r_l(pose, theta) = |p + R a_l - C_l| - len_l = 0 by Newton's method. By the implicit
function theorem d pose / d theta = -(dr / d pose)^-1 dr / d theta, and a reflector r is seen at m = Q (p + R r) + t.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.model import parameters as kinds
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import FIXED, Kind
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, cross, dot, rotation
from pipeline.machine.kinematics import rotation_axes

_STEPS = 25
_LONGEST_STEP = 0.2
"""Longest Newton step, in metres and radians."""
_CLOSED_M = 1e-13


@dataclass(frozen=True, eq=False)
class Closed:
    """A machine assembled at encoder positions.

    Attributes
    ----------
    pose : (n, 6)
        x, y, z, rx, ry, rz.
    miss_m : (n,)
        What is missing most of a link's length; large where the machine cannot be assembled near the guess.
    arms_m : (n, 6, 3)
        R a_l.
    directions : (n, 6, 3)
        Unit vectors u_l along the links, from cart to platform.
    R : (n, 3, 3)
        Orientation of the platform.
    """

    pose: FloatArray
    miss_m: FloatArray
    arms_m: FloatArray
    directions: FloatArray
    R: FloatArray


def close(model: Model, q_m: FloatArray, guess: FloatArray) -> Closed:
    """Assemble the machine for encoders (n, 5), starting Newton's method at poses (n, 6)."""
    joints, lengths, pose = model.cart_joints(q_m), model.link_lengths(q_m), np.array(guess, dtype=float)
    # A pose that gets lost is told by its miss.
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            closed, miss = _links(model, joints, lengths, pose)
            if closed.miss_m.max(initial=0.0) < _CLOSED_M:
                break
            step = np.linalg.solve(by_pose(closed), -miss[..., None])[..., 0]
            longest = np.abs(step).max(axis=1, keepdims=True)
            pose = pose + step * np.minimum(1.0, _LONGEST_STEP / np.maximum(longest, 1e-300))
        return _links(model, joints, lengths, pose)[0]


def _links(model: Model, joints: FloatArray, lengths: FloatArray, pose: FloatArray) -> tuple[Closed, FloatArray]:
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    arms = model.platform_points_m @ np.swapaxes(R, 1, 2)
    vectors = pose[:, None, :3] + arms - joints
    found = np.sqrt(dot(vectors, vectors))
    miss = found - lengths
    return Closed(pose, np.abs(miss).max(axis=1), arms, vectors / found[..., None], R), miss


def by_pose(closed: Closed) -> FloatArray:
    """Differentiate the closures by the pose. Shape (n, 6, 6)."""
    moments = cross(closed.arms_m, closed.directions)
    return np.concatenate([closed.directions, moments @ rotation_axes(closed.pose)], axis=-1)


def positions(model: Model, closed: Closed) -> FloatArray:
    """See all reflectors in the tracker's frame. Shape (n, reflectors, 3)."""
    points = closed.pose[:, None, :3] + model.reflectors_m @ np.swapaxes(closed.R, 1, 2)
    return np.asarray(points @ model.rotation.T + model.translation_m)


def position_jacobian(model: Model, q_m: FloatArray, closed: Closed) -> FloatArray:
    """Differentiate the positions seen by all parameters, at a tracker's frame that is not turned since it was set.

    Shape (n, reflectors, 3, parameters).
    """
    moved, turned = pose_rates(model, q_m, closed)
    parameters, count = model.parameters, len(model.reflectors_m)
    arms = model.reflectors_m @ np.swapaxes(closed.R, 1, 2)
    rates = moved[:, None] + _crossed(turned[:, None], arms)
    J = np.einsum("ij,nrjp->nrip", model.rotation, rates)
    own = parameters.slice(kinds.REFLECTORS).start
    for k in range(count):
        J[:, k, :, own + 3 * k : own + 3 * k + 3] += model.rotation @ closed.R
    seen = positions(model, closed) - model.translation_m
    frame = parameters.slice(kinds.TRACKER).start
    for axis in range(3):
        J[..., frame + axis] = np.cross(np.eye(3)[axis], seen)
        J[..., axis, frame + 3 + axis] = 1.0
    return np.asarray(J)


def pose_rates(model: Model, q_m: FloatArray, closed: Closed) -> tuple[FloatArray, FloatArray]:
    """Differentiate the platform's place and orientation (a rotation vector) by all parameters. Two (n, 3, count)."""
    rates: FloatArray = -np.linalg.solve(by_pose(closed), by_parameters(model, q_m, closed)).astype(float, copy=False)
    return rates[:, :3], rotation_axes(closed.pose) @ rates[:, 3:]


def by_parameters(model: Model, q_m: FloatArray, closed: Closed) -> FloatArray:
    """Differentiate the closures by all parameters. Shape (n, 6, count)."""
    u, parameters = closed.directions, model.parameters
    F = np.zeros((len(q_m), 6, parameters.count))

    def at(kind: Kind, index: int) -> int:
        return int(parameters.slice(kind).start) + index

    along = model.actuators(q_m)[:, :3] - model.middles_m[:3]
    shown = q_m - model.middles_m
    slope = np.concatenate([np.ones((3, 1)), model.directions_rad], axis=1)
    in_platform = np.einsum("nij,nli->nlj", closed.R, u)
    for link, arm in enumerate(ARM_OF_LINK):
        F[:, link, at(kinds.PLATFORM, 3 * link) : at(kinds.PLATFORM, 3 * link + 3)] = in_platform[:, link]
        F[:, link, at(kinds.OFFSETS, 3 * link) : at(kinds.OFFSETS, 3 * link + 3)] = -u[:, link]
        F[:, link, at(kinds.RAILS, 2 * arm) : at(kinds.RAILS, 2 * arm + 2)] = -u[:, link, 1:]
        F[:, link, at(kinds.DIRECTIONS, 2 * arm) : at(kinds.DIRECTIONS, 2 * arm + 2)] = (
            -u[:, link, 1:] * along[:, arm, None]
        )
        F[:, link, at(kinds.ZEROS, arm)] = -(u[:, link] @ slope[arm])
        F[:, link, at(kinds.SCALES, arm)] = -(u[:, link] @ slope[arm]) * shown[:, arm]
    for index, link in enumerate(FIXED):
        F[:, link, at(kinds.LENGTHS, index)] = -1.0
    for actuator, link in enumerate(TELESCOPES, 3):
        F[:, link, at(kinds.ZEROS, actuator)] = -1.0
        F[:, link, at(kinds.SCALES, actuator)] = -shown[:, actuator]
    return F


def _crossed(turned: FloatArray, arms: FloatArray) -> FloatArray:
    """Compute omega x arm for rotation vectors (n, 1, 3, p) and arms (n, r, 3). Shape (n, r, 3, p)."""
    a = arms[..., None]
    columns = [turned[:, :, i - 2] * a[:, :, i - 1] - turned[:, :, i - 1] * a[:, :, i - 2] for i in range(3)]
    return np.stack(columns, axis=2)
