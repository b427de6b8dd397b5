"""Inverse kinematics for all working modes, forward kinematics by Newton's method."""

from dataclasses import dataclass

import numpy as np

from pipeline.arguments import (
    require_array,
    require_number,
    require_one_length,
    require_shape,
    require_whole_numbers,
)
from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.errors import ArgumentError, ForwardKinematicsError
from pipeline.machine.geometry import (
    ACTUATORS,
    ARM_OF_LINK,
    LINKS,
    MODE_SIGNS,
    MODES,
    PRIMARY,
    TELESCOPES,
    Machine,
    cart_joints,
    cross,
    dot,
    link_lengths,
    link_vectors,
    platform_arms,
    rotation_x,
    rotation_z,
)
from pipeline.machine.pose import full_pose
from pipeline.machine.rails import across_rails, along_rails, rail_origins
from pipeline.machine.triangle import dependent_angle, on_axis, third_discriminant

_ARMS = ARM_OF_LINK[PRIMARY]
_NEWTON_STEPS = 30
_MAX_STEP = 0.2
"""Longest Newton step, in metres and radians: farther than that the linearisation means nothing."""
_MAX_CORRECTION = 0.1
"""How far, in metres and radians, a pose may be from its prediction on a curve: farther off is another assembly."""


@dataclass(frozen=True, eq=False)
class InverseSolution:
    """Actuator positions for controlled poses in given working modes; rows out of reach hold NaN.

    Attributes
    ----------
    pose : (n, 6)
        x, y, z, rx, ry, rz with the dependent ry.
    q_m : (n, 5)
        Actuator positions c1, c2, c3, l2b, l3b.
    discriminants_m2 : (n, 3)
        D_k = L^2 - dy^2 - dz^2 per arm, distances across its rail: zero at its serial singularity, negative out of
        reach, NaN where it depends on a ry that does not exist.
    reachable : (n,)
        All three arms reach their rails and the triangle closes; limits are not looked at.
    """

    pose: FloatArray
    q_m: FloatArray
    discriminants_m2: FloatArray
    reachable: BoolArray


def inverse_kinematics(
    machine: Machine,
    controlled: FloatArray,
    modes: IntArray,
    gates: IntArray | None = None,
    ry_rad: FloatArray | None = None,
) -> InverseSolution:
    """Solve c_k = (A - b) . d_k -/+ sqrt(D_k) for controlled poses (n, 5) in working modes (n,).

    d_k is the direction of the rail, e_x on parallel ones.

    ry follows from the triangle, unless it is known: `ry_rad` (n,). `gates` (n,) names per row the arm (1, 2, 3; 0
    for none) whose D is zero by construction: rounding is kept from making it negative or leaving the two modes apart.

    Raises
    ------
    ArgumentError
        If poses, modes, gates or angles have other shapes, or there is no such mode or arm.
    """
    controlled = require_array("controlled", controlled, ("...", 5), finite=False).reshape(-1, 5)
    modes = require_whole_numbers("modes", modes, 0, len(MODES) - 1).reshape(-1)
    require_one_length(controlled=controlled, modes=modes)
    if ry_rad is not None:
        require_shape("ry_rad", ry_rad, (len(controlled),))
    if gates is not None:
        gates = require_whole_numbers("gates", gates, 0, 3)
        require_one_length(controlled=controlled, gates=gates)
    signs = MODE_SIGNS[modes]
    if gates is not None:
        at_gate = np.flatnonzero(gates)
        signs[at_gate, gates[at_gate] - 1] = 0.0
    pose = full_pose(controlled, dependent_angle(machine, controlled, signs[:, 2]) if ry_rad is None else ry_rad)
    joints = platform_arms(machine, pose)
    joints += pose[:, None, :3]
    D = _discriminants(machine, pose, joints)
    D[signs == 0.0] = 0.0
    with np.errstate(invalid="ignore"):
        carts = _along(machine, joints) + signs * np.sqrt(D)
    telescopes = joints[:, TELESCOPES] - cart_joints(machine, carts)[:, TELESCOPES]
    q = np.column_stack([carts, np.sqrt(dot(telescopes, telescopes))])
    return InverseSolution(pose, q, D, np.isfinite(q).all(axis=1))


def discriminants(machine: Machine, pose: FloatArray) -> FloatArray:
    """D_k of the three arms, as of `InverseSolution`, for poses (n, 6) that hold ry. Shape (n, 3)."""
    joints = platform_arms(machine, pose)
    joints += pose[:, None, :3]
    return _discriminants(machine, pose, joints)


def _discriminants(machine: Machine, pose: FloatArray, joints: FloatArray) -> FloatArray:
    if machine.has_parallel_rails:
        across = joints[:, PRIMARY, 1:] - machine.cart_offsets_m[PRIMARY, 1:] - machine.rails_m
        D: FloatArray = machine.lengths_m[PRIMARY] ** 2 - across[..., 0] ** 2 - across[..., 1] ** 2
    else:
        distant = across_rails(machine, _from_origins(machine, joints), _ARMS)
        D = machine.lengths_m[PRIMARY] ** 2 - dot(distant, distant)
    if on_axis(machine):
        rows = np.flatnonzero(np.isnan(pose[:, 4]))
        D[rows, 2] = third_discriminant(machine, pose[rows][:, [0, 1, 2, 3, 5]], np.zeros(len(rows)))
    return D


def _along(machine: Machine, joints: FloatArray) -> FloatArray:
    """Positions along the rails, less the offsets, where primary joints would be abreast of A (n, 6, 3). (n, 3)."""
    if machine.has_parallel_rails:
        along: FloatArray = joints[:, PRIMARY, 0] - machine.cart_offsets_m[PRIMARY, 0]
        return along
    return along_rails(machine, _from_origins(machine, joints), _ARMS)


def _from_origins(machine: Machine, joints: FloatArray) -> FloatArray:
    """A - C of the primary links with all carts at q = 0, for platform joints (n, 6, 3). Shape (n, 3, 3)."""
    offset: FloatArray = joints[:, PRIMARY] - machine.cart_offsets_m[PRIMARY] - rail_origins(machine)
    return offset


def closure_residual(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """|A_l - C_l| - len_l for poses (..., 6) and actuators (..., 5): what each link misses. Shape (..., 6)."""
    vectors = link_vectors(machine, pose, q_m[..., :3])
    residual: FloatArray = np.sqrt(dot(vectors, vectors)) - link_lengths(machine, q_m[..., 3:])
    return residual


def closure_jacobian(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Differentiate the closure residual by the pose: H' with its moments turned into angles.

    Row l is [u_l ; E' (A'_l x u_l)] with E = [e_x, y_platform, Rx e_z], the axes that rx, ry, rz turn about.
    Shape (..., 6, 6).
    """
    vectors = link_vectors(machine, pose, q_m[..., :3])
    u = vectors / np.sqrt(dot(vectors, vectors))[..., None]
    moments = cross(platform_arms(machine, pose), u)
    return np.concatenate([u, moments @ rotation_axes(pose)], axis=-1)


def pose_jacobian(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    """Differentiate the pose by the actuators on the closure r(pose, q) = 0: -(dr/dpose)^-1 dr/dq. Shape (..., 6, 5).

    A cart pulls its links by -u . d_k, a telescope lengthens its own: dr/dc_k = -u_l . d_k for the links l of arm k
    and dr/dq_4 = -1 for 2b, dr/dq_5 = -1 for 3b.
    """
    return solve_rates(machine, closure_jacobian(machine, pose, q_m))


def solve_rates(machine: Machine, by_pose: FloatArray) -> FloatArray:
    """Solve for the derivative of the pose by the actuators, for regular closure Jacobians (..., 6, 6).

    The first columns of a closure Jacobian hold the u_l that dr/dq is made of. Shape (..., 6, 5).
    """
    by_q = np.zeros((*by_pose.shape[:-1], len(ACTUATORS)))
    by_q[..., np.arange(len(LINKS)), ARM_OF_LINK] = -along_rails(machine, by_pose[..., :3], ARM_OF_LINK)
    by_q[..., TELESCOPES, [3, 4]] = -1.0
    return np.linalg.solve(by_pose, -by_q).astype(float, copy=False)


def rotation_axes(pose: FloatArray) -> FloatArray:
    """Give the axes e_x, y_platform and Rx e_z that rx, ry and rz turn about, as columns. Shape (..., 3, 3)."""
    Rx = rotation_x(pose[..., 3])
    axis_x = np.broadcast_to([1.0, 0.0, 0.0], (*pose.shape[:-1], 3))
    axis_y = (Rx @ rotation_z(pose[..., 5]))[..., 1]
    return np.stack([axis_x, axis_y, Rx[..., 2]], axis=-1)


def newton(
    machine: Machine, q_m: FloatArray, guess: FloatArray, tolerance_m: float = 1e-12
) -> tuple[FloatArray, FloatArray]:
    """Improve guessed poses (n, 6) towards actuator positions (n, 5).

    Returns the poses and the largest link misses (n,). Rows that do not converge are returned with the miss they
    ended at (infinite where the closure is singular); it is the caller's to judge it.
    """
    pose = np.array(guess, dtype=float)
    residual = closure_residual(machine, pose, q_m)
    miss = np.abs(residual).max(axis=-1)
    active = np.flatnonzero(miss > tolerance_m)
    for _ in range(_NEWTON_STEPS):
        if active.size == 0:
            break
        # A guess may put a platform joint on its cart joint: that link has no direction, and J is singular.
        with np.errstate(invalid="ignore"):
            J = closure_jacobian(machine, pose[active], q_m[active])
            singular = ~(np.abs(np.linalg.det(J)) > 1e-14)
        J[singular] = np.eye(6)
        step = np.linalg.solve(J, -residual[active][..., None])[..., 0]
        longest = np.abs(step).max(axis=-1, keepdims=True)
        step *= np.minimum(1.0, _MAX_STEP / np.maximum(longest, 1e-300))
        step[singular] = 0.0
        previous = miss[active]
        pose[active] += step
        residual[active] = closure_residual(machine, pose[active], q_m[active])
        miss[active] = np.where(singular, np.inf, np.abs(residual[active]).max(axis=-1))
        # At rounding level Newton stops improving: that is convergence, and anything else goes on.
        settled = (miss[active] >= 0.5 * previous) & (miss[active] < 1e-10)
        active = active[~settled & ~singular & (miss[active] > tolerance_m)]
    return pose, miss


def forward_kinematics(machine: Machine, q_m: FloatArray, guess: FloatArray, tolerance_m: float = 1e-10) -> FloatArray:
    """Find the poses (n, 6) near the guesses (n, 6) that close all six links for actuator positions (n, 5).

    One guess (6,) serves all rows.

    Raises
    ------
    ArgumentError
        If they have other shapes, or the tolerance is not positive.
    ForwardKinematicsError
        When a row ends with a link missing its length by more than `tolerance_m`, or holds NaN.
    """
    q_m = require_array("q_m", q_m, ("...", 5), finite=False).reshape(-1, 5)
    guess = require_array("guess", guess, ("...", 6), finite=False)
    if guess.shape not in ((6,), (1, 6), (len(q_m), 6)):
        raise ArgumentError(
            f"guess: expected one for each of {len(q_m)} rows of q_m, or one for all, not {guess.shape}"
        )
    guess = np.broadcast_to(guess, (len(q_m), 6))
    tolerance_m = require_number("tolerance_m", tolerance_m, above=0.0)
    pose, miss = newton(machine, q_m, guess)
    failed = ~(miss <= tolerance_m)
    if failed.any():
        index = int(np.argmax(failed))
        raise ForwardKinematicsError(float(miss[index]), index, list(map(float, guess[index])))
    return pose


def follow(machine: Machine, q_m: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
    """March along curves of actuator positions (n, m, 5) from start poses (n, 6), all curves in step.

    Every pose is predicted from the last two and corrected by Newton's method; a curve is lost where that fails or
    leads to another assembly. Returns poses (n, m, 6) and the largest link misses (n, m); a lost curve keeps its
    last pose and an infinite miss from there on.
    """
    n, m = q_m.shape[:2]
    poses = np.empty((n, m, 6))
    misses = np.full((n, m), np.inf)
    alive = np.ones(n, dtype=bool)
    previous = np.array(start, dtype=float)
    velocity = np.zeros((n, 6))
    for k in range(m):
        poses[:, k] = previous
        predicted = previous[alive] + velocity[alive]
        pose, miss = newton(machine, q_m[alive, k], predicted)
        good = (miss <= 1e-9) & (np.abs(pose - predicted).max(axis=1) <= _MAX_CORRECTION)
        rows = np.flatnonzero(alive)
        alive[rows[~good]] = False
        rows = rows[good]
        poses[rows, k], misses[rows, k] = pose[good], miss[good]
        velocity[rows] = (pose[good] - previous[rows]) if k else 0.0
        previous[rows] = pose[good]
        if not alive.any():
            poses[:, k:] = previous[:, None]
            break
    return poses, misses
