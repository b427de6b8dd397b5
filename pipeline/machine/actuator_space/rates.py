"""First-order kinematics: how platform and links move with each actuator, the others held."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import (
    ACTUATORS,
    ARM_OF_LINK,
    LINKS,
    TELESCOPES,
    Machine,
    dot,
    link_vectors,
    platform_arms,
    rotation,
)
from pipeline.machine.rails import along_rails
from pipeline.machine.statics import statics_matrix

_TELESCOPE_COLUMNS = [3, 4]
EXTENSIONS = np.zeros((len(LINKS), len(ACTUATORS)))
"""How fast each link grows longer with each actuator: 1 for a telescope and its own drive. Shape (6, 5)."""
EXTENSIONS[TELESCOPES, _TELESCOPE_COLUMNS] = 1.0


@dataclass(frozen=True, eq=False)
class ActuatorRates:
    """The machine at n poses, and its velocities per actuator velocity.

    Attributes
    ----------
    rotation : (n, 3, 3)
        R of the platform.
    H : (n, 6, 6)
        Statics matrices (1)-(2).
    directions, arms : (n, 6, 3)
        Unit vectors u_l from cart to platform, and arms A'_l from the TCP to the platform joints.
    lengths_m : (n, 6)
        Lengths of the links.
    twist : (n, 6, 5)
        Velocity of the TCP (m/s per m/s) and angular velocity of the platform (rad/s per m/s).
    tips : (n, 6, 3, 5)
        Velocities of the platform joints relative to their cart joints.
    """

    rotation: FloatArray
    H: FloatArray
    directions: FloatArray
    arms: FloatArray
    lengths_m: FloatArray
    twist: FloatArray
    tips: FloatArray

    @property
    def spin(self) -> FloatArray:
        """Angular velocity of the platform per actuator velocity, rad/m, shape (n, 3, 5)."""
        return self.twist[:, 3:]


def actuator_rates(
    machine: Machine, pose: FloatArray, carts_m: FloatArray, H: FloatArray | None = None
) -> ActuatorRates:
    """Solve H' (v, L omega) = B qd for the twist per actuator velocity, at poses (n, 6) with carts (n, 3).

    Row l of it is the rate of link l's length, u_l . (v + omega x A'_l) = u_l . d_k cd_k + ld_l: B holds u_l . d_k
    in the column of the link's cart and 1 in that of its telescope. L is the characteristic length. Twists, and the
    velocities of the tips with them, are NaN where H is singular.

    Parameters
    ----------
    H : (n, 6, 6)
        Statics matrices, if they are known.
    """
    H = statics_matrix(machine, pose, carts_m) if H is None else H
    vectors, arms = link_vectors(machine, pose, carts_m), platform_arms(machine, pose)
    lengths = np.sqrt(dot(vectors, vectors))
    by_actuator = np.broadcast_to(EXTENSIONS, (len(pose), *EXTENSIONS.shape)).copy()
    by_actuator[:, np.arange(len(LINKS)), ARM_OF_LINK] = along_rails(machine, H[:, :3].swapaxes(1, 2), ARM_OF_LINK)
    twist = solve_regular(np.swapaxes(H, -1, -2), by_actuator)
    twist[:, 3:] /= machine.characteristic_length_m
    # v + omega x A', column by column of the actuators; a cart takes its own joints along.
    tips = np.cross(twist[:, None, 3:], arms[..., None], axis=2) + twist[:, None, :3]
    tips[:, np.arange(len(LINKS)), :, ARM_OF_LINK] -= machine.rail_directions[ARM_OF_LINK][:, None]
    R = rotation(pose[:, 3], pose[:, 4], pose[:, 5])
    return ActuatorRates(R, H, vectors / lengths[..., None], arms, lengths, twist, tips)


def solve_regular(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solve matrices (n, m, m) for right sides (n, m, k); NaN where a matrix is singular."""
    try:
        return np.linalg.solve(matrices, right).astype(float, copy=False)
    except np.linalg.LinAlgError:
        regular = np.linalg.det(matrices) != 0.0
    solved = np.full(right.shape, np.nan)
    solved[regular] = np.linalg.solve(matrices[regular], right[regular])
    return solved
