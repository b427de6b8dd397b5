"""Where rails lead: the places of carts, components along rails, and the machine with parallel rails in their place."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.machine.geometry import Machine, dot


def rail_origins(machine: Machine) -> FloatArray:
    """Return where carts are at q = 0: (0, y, z) of each rail. Shape (3, 3)."""
    return np.column_stack([np.zeros(len(machine.rails_m)), machine.rails_m])


def rail_points(machine: Machine, carts_m: FloatArray) -> FloatArray:
    """Place the carts, (0, y, z) + q_k d_k, at positions (..., 3) along their rails. Shape (..., 3, 3)."""
    points: FloatArray = rail_origins(machine) + carts_m[..., None] * machine.rail_directions
    return points


def along_rails(machine: Machine, vectors: FloatArray, arms: IntArray) -> FloatArray:
    """v_l . d_k of vectors (..., n, 3), each along the rail of its arm (n,): x on parallel rails. Shape (..., n)."""
    if machine.has_parallel_rails:
        return vectors[..., 0]
    return dot(vectors, machine.rail_directions[arms])


def across_rails(machine: Machine, vectors: FloatArray, arms: IntArray) -> FloatArray:
    """v_l - (v_l . d_k) d_k of vectors (..., n, 3), likewise. Shape (..., n, 3)."""
    across: FloatArray = vectors - along_rails(machine, vectors, arms)[..., None] * machine.rail_directions[arms]
    return across


def rail_frame(machine: Machine, arm: int) -> FloatArray:
    """Return the rotation T (3, 3) that turns a rail to X, with y as near to Y as can be; the identity on X."""
    along = machine.rail_directions[arm]
    across = np.array([0.0, 1.0, 0.0]) - along[1] * along
    across /= np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)])


def with_parallel_rails(machine: Machine) -> Machine:
    """Return the machine with rails along X through the middles of their travel; itself if its rails are parallel.

    x enters its poses through the carts alone. It is as far from the machine as the rails' slopes lead within half of
    their travel.
    """
    if machine.has_parallel_rails:
        return machine
    middle = machine.travel_m.mean(axis=1, keepdims=True)
    rails = machine.rails_m + middle * machine.rail_directions[:, 1:]
    return replace(machine, rails_m=rails, rail_directions=np.tile([1.0, 0.0, 0.0], (3, 1)))
