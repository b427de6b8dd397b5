"""The machine at many poses: kinematic and static quantities, each computed once, when first needed."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness, least_stiffness
from pipeline.machine.clearance import link_distances
from pipeline.machine.dynamics import holding_forces
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import closure_residual
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.statics import condition_number, det_sign, statics_matrix
from pipeline.machine.working_modes import reach_along_rails


@dataclass(frozen=True, eq=False)
class PoseSamples:
    """Poses and actuator positions of one machine, and what follows from them.

    Attributes
    ----------
    machine : Machine
        The machine.
    pose, q_m : (n, 6), (n, 5)
        x, y, z, rx, ry, rz; actuator positions.
    """

    machine: Machine
    pose: FloatArray
    q_m: FloatArray

    def __len__(self) -> int:
        return len(self.pose)

    @property
    def carts_m(self) -> FloatArray:
        """Cart positions, shape (n, 3)."""
        return self.q_m[:, :3]

    @property
    def controlled(self) -> FloatArray:
        """Controlled coordinates x, y, z, rx, rz, shape (n, 5)."""
        return self.pose[:, CONTROLLED]

    @cached_property
    def H(self) -> FloatArray:  # noqa: N802  # the paper's symbol
        """Statics matrices (1)-(2), shape (n, 6, 6)."""
        return statics_matrix(self.machine, self.pose, self.carts_m)

    @cached_property
    def kappa(self) -> FloatArray:
        """Condition number of H, infinite at a Type-II singularity, shape (n,)."""
        return condition_number(self.H)

    @cached_property
    def det_sign(self) -> FloatArray:
        """Sign of det H, shape (n,)."""
        return det_sign(self.H)

    @property
    def signed_inverse_kappa(self) -> FloatArray:
        """sign(det H) / kappa: continuous, and zero at a Type-II singularity. Shape (n,)."""
        return np.asarray(self.det_sign / self.kappa, dtype=float)

    @cached_property
    def link_distances_m(self) -> FloatArray:
        """Distances between the axes of all links that share no joint, shape (n, pairs)."""
        return link_distances(self.machine, self.pose, self.carts_m)

    @property
    def link_distance_m(self) -> FloatArray:
        """Least of these distances, shape (n,)."""
        return np.asarray(self.link_distances_m.min(axis=1), dtype=float)

    @cached_property
    def closure_residual_m(self) -> FloatArray:
        """Largest amount by which a link misses its length, shape (n,)."""
        return np.asarray(np.abs(closure_residual(self.machine, self.pose, self.q_m)).max(axis=1), dtype=float)

    @cached_property
    def reach_m(self) -> FloatArray:
        """(C - A) . d of the primary links: positive in mode R, negative in mode L. Shape (n, 3)."""
        return reach_along_rails(self.machine, self.pose, self.carts_m)

    @cached_property
    def holding_forces_n(self) -> FloatArray:
        """Forces of the five drives and along the six links that hold the machine, without friction. Shape (n, 11).

        Raises
        ------
        ValueError
            For a machine without masses.
        """
        forces = holding_forces(self.machine, self.machine.known_masses, self.pose, self.H)
        return np.concatenate([forces.drive_n, forces.link_n], axis=1)

    @cached_property
    def gravity_stiffness_npm(self) -> FloatArray:
        """Least eigenvalue of the derivative of holding forces by actuators, -inf at a singular pose. Shape (n,).

        Raises
        ------
        ValueError
            For a machine without masses.
        """
        rates = actuator_rates(self.machine, self.pose, self.carts_m, self.H)
        return least_stiffness(gravity_stiffness(self.machine, rates))

    def with_known(self, **values: FloatArray) -> Self:
        """Return the samples with known quantities, by their names here, so that they are not recomputed."""
        known = replace(self)
        known.__dict__.update(values)
        return known

    def take(self, rows: IntArray | BoolArray) -> Self:
        """Keep some of the samples, and what is already known of them."""
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        taken = type(self)(**{name: value if name == "machine" else value[rows] for name, value in columns.items()})
        for name, value in self.__dict__.items():
            if name not in columns:
                taken.__dict__[name] = value[rows]
        return taken
