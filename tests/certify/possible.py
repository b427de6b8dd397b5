"""Machines of an ellipsoid, many at a time, as floats: their parts, and their poses by Newton's method."""

from dataclasses import dataclass

import numpy as np

from pipeline.inclusion.calibrated.ellipsoid import (
    FIXED,
    LENGTHS,
    OFFSETS,
    PARAMETERS,
    PLATFORM,
    RAILS,
    SCALES,
    ZEROS,
    Ellipsoid,
)
from pipeline.machine import Machine
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, rotation
from pipeline.machine.kinematics import rotation_axes


def some_ellipsoid(std_m: float, sigma: float = 3.0, columns: int = 12, seed: int = 0) -> Ellipsoid:
    """Give correlated errors of that size to all parameters; scales are in parts."""
    factor = np.random.default_rng(seed).normal(size=(PARAMETERS, columns)) * std_m / np.sqrt(columns)
    return Ellipsoid(factor, sigma, np.array([1.0, 1.05, 0.98, 1.1, 1.2]), np.array([1.0, 1.001, 0.999, 1.0, 1.002]))


def on_the_sphere(ellipsoid: Ellipsoid, count: int, seed: int = 1) -> np.ndarray:
    """Draw u (count, m) with |u| = k."""
    u = np.random.default_rng(seed).normal(size=(count, ellipsoid.factor.shape[1]))
    return ellipsoid.sigma * u / np.linalg.norm(u, axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class Machines:
    """N machines at actuators q (5,) of the configured one: points and joints (N, 6, 3), lengths and actuators."""

    points: np.ndarray
    joints: np.ndarray
    lengths: np.ndarray
    actuators: np.ndarray
    rails: np.ndarray

    @classmethod
    def at(cls, machine: Machine, ellipsoid: Ellipsoid, u: np.ndarray, q: np.ndarray) -> "Machines":
        """Build machines W u for u (N, m)."""
        theta, n = u @ ellipsoid.factor.T, len(u)
        shown = (q - ellipsoid.zero_at_m) / ellipsoid.scale
        actuators = q + theta[:, ZEROS] + theta[:, SCALES] * shown
        rails = machine.rails_m + theta[:, RAILS].reshape(n, 3, 2)
        joints = machine.cart_offsets_m + theta[:, OFFSETS].reshape(n, 6, 3)
        joints[:, :, 0] += actuators[:, ARM_OF_LINK]
        joints[:, :, 1:] += rails[:, ARM_OF_LINK]
        lengths = np.tile(machine.lengths_m, (n, 1))
        lengths[:, FIXED] += theta[:, LENGTHS]
        lengths[:, TELESCOPES] = actuators[:, 3:]
        points = machine.platform_points_m + theta[:, PLATFORM].reshape(n, 6, 3)
        return cls(points, joints, lengths, actuators, rails)

    def arms(self, pose: np.ndarray) -> np.ndarray:
        """Turn the points at poses (N, 6)."""
        return np.einsum("nij,nlj->nli", rotation(*pose[:, 3:].T), self.points)

    def vectors(self, pose: np.ndarray) -> np.ndarray:
        """Compute v_l, (N, 6, 3)."""
        return pose[:, None, :3] + self.arms(pose) - self.joints

    def residuals(self, pose: np.ndarray) -> np.ndarray:
        """Compute f_l, (N, 6)."""
        return ((self.vectors(pose) ** 2).sum(axis=2) - self.lengths**2) / 2.0

    def jacobian(self, pose: np.ndarray) -> np.ndarray:
        """Compute f', (N, 6, 6)."""
        v = self.vectors(pose)
        return np.concatenate([v, np.cross(self.arms(pose), v) @ rotation_axes(pose)], axis=2)

    def statics(self, pose: np.ndarray, length_m: float) -> np.ndarray:
        """Compute H', (N, 6, 6)."""
        v = self.vectors(pose)
        return np.concatenate([v, np.cross(self.arms(pose), v) / length_m], axis=2) / self.lengths[..., None]

    def assembled(self, pose: np.ndarray) -> np.ndarray:
        """Assemble all machines from a pose (6,) on, (N, 6)."""
        found = np.tile(pose, (len(self.points), 1))
        for _ in range(20):
            missing = self.residuals(found)
            if np.abs(missing).max() < 1e-13:
                break
            found -= np.linalg.solve(self.jacobian(found), missing[..., None])[..., 0]
        assert np.abs(self.residuals(found)).max() < 1e-12
        return found


def towards(ellipsoid: Ellipsoid, rates: np.ndarray) -> np.ndarray:
    """Give u with |u| = k in the directions, both ways, in which quantities with gradients (c, m) change fastest."""
    unit = rates / np.linalg.norm(rates, axis=1, keepdims=True)
    return ellipsoid.sigma * np.concatenate([unit, -unit])
