"""What the drives feel at poses, in numbers: reflected mass, stiffness and damping, and amplification to the TCP.

Where a figure is the largest or least over all directions in actuator space, that direction comes with it.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.actuator_space.gravity import gravity_stiffness
from pipeline.machine.actuator_space.inertia import mass_matrix, velocity_damping
from pipeline.machine.actuator_space.rates import ActuatorRates
from pipeline.machine.geometry import ACTUATORS, Machine


@dataclass(frozen=True, eq=False)
class Directed:
    """A figure at n poses, values (n,), and the direction in actuator space that it belongs to, unit vectors (n, 5)."""

    value: FloatArray
    along: FloatArray


@dataclass(frozen=True, eq=False)
class Amplification:
    """How far the TCP moves for movements, or errors, of the actuators.

    Attributes
    ----------
    position : Directed
        Largest singular value of the position's derivative by the actuators: metres per metre.
    angle : Directed
        The same of the platform's rotation: radians per metre.
    position_by_drive, angle_by_drive : (n, 5)
        For each actuator alone.
    """

    position: Directed
    angle: Directed
    position_by_drive: FloatArray
    angle_by_drive: FloatArray


@dataclass(frozen=True, eq=False)
class DriveFigures:
    """What the drives feel at n poses of a machine with masses.

    Attributes
    ----------
    reflected_mass_kg : (n, 5)
        Diagonal of M: the force per acceleration of each drive while the others hold their positions.
    worst_mass_kg : Directed
        Largest eigenvalue of M.
    stiffness_npm : Directed
        Least eigenvalue of dF/dq of the holding forces.
    damping_nspm : Directed
        Least eigenvalue of the symmetric part of dF/dqd in motion, which is dM/dt.
    """

    reflected_mass_kg: FloatArray
    worst_mass_kg: Directed
    stiffness_npm: Directed
    damping_nspm: Directed


def amplification(rates: ActuatorRates) -> Amplification:
    """Compute how far position and rotation of the TCP follow the actuators, at n regular poses."""
    (position, by_drive), (angle, angle_by_drive) = (_amplified(part) for part in np.split(rates.twist, 2, axis=1))
    return Amplification(position, angle, by_drive, angle_by_drive)


def drive_figures(machine: Machine, rates: ActuatorRates, qd_mps: FloatArray) -> DriveFigures:
    """Compute what the drives feel at n regular poses, moving with qd (n, 5).

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    M = mass_matrix(machine, rates)
    damping = velocity_damping(machine, rates, qd_mps)
    return DriveFigures(
        reflected_mass_kg=np.diagonal(M, axis1=1, axis2=2),
        worst_mass_kg=_eigenvalue(M, -1),
        stiffness_npm=_eigenvalue(gravity_stiffness(machine, rates), 0),
        damping_nspm=_eigenvalue((damping + np.swapaxes(damping, 1, 2)) / 2.0, 0),
    )


def mode_words(direction: FloatArray) -> str:
    """Name a direction (5,) in actuator space by its larger parts, the largest positive: "0.53 l2b + 0.83 l3b"."""
    turned = direction * np.sign(direction[np.abs(direction).argmax()])
    parts = [
        f"{'-' if part < 0.0 else '+'} {abs(part):.2f} {name}"
        for part, name in zip(turned.tolist(), ACTUATORS, strict=True)
        if abs(part) > 0.25 * turned.max()
    ]
    return " ".join(parts).removeprefix("+ ")


def _amplified(J: FloatArray) -> tuple[Directed, FloatArray]:
    _, values, directions = np.linalg.svd(J)
    return Directed(values[:, 0], directions[:, 0]), np.linalg.norm(J, axis=1)


def _eigenvalue(matrices: FloatArray, which: int) -> Directed:
    values, directions = np.linalg.eigh(matrices)
    return Directed(values[:, which], directions[:, :, which])
