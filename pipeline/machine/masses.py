"""What the machine weighs: carts, links, platform, load; lumped into carts and one rigid body.

Links and telescopes count half to each end: the half at the cart moves with the cart, the half at the platform is a
point of the platform at its joint. What is left of a link carries nothing but the force along its axis.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.config import DynamicsConfig

_FLOATS = npt.NDArray[np.float64]
_IS_TELESCOPE = np.array([False, False, True, False, True, False])


@dataclass(frozen=True, eq=False)
class Masses:
    """Masses in kilograms, links in the order 1, 2a, 2b, 3a, 3b, 3c.

    Attributes
    ----------
    cart_kg : float
        Each cart by itself.
    link_kg : (6,)
        Links and telescopes, whole.
    platform_kg : float
        Platform with tool, without load.
    platform_centre_m : (3,)
        Its centre of mass in the platform frame, from the TCP.
    platform_inertia_kgm2 : (3, 3)
        Its inertia about the centre of mass, in the platform frame.
    load_kg : float
        A point at the TCP.
    gravity_mps2 : (3,)
        Acceleration of free fall.
    friction_n : (5,)
        Dry friction of the drives.
    """

    cart_kg: float
    link_kg: _FLOATS
    platform_kg: float
    platform_centre_m: _FLOATS
    platform_inertia_kgm2: _FLOATS
    load_kg: float
    gravity_mps2: _FLOATS
    friction_n: _FLOATS


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A body: mass (kg), centre of mass (3,) and inertia about it (3, 3), both in the body's frame."""

    mass_kg: float
    centre_m: _FLOATS
    inertia_kgm2: _FLOATS


def build_masses(config: DynamicsConfig) -> Masses:
    """Turn the configuration's masses into arrays."""
    return Masses(
        cart_kg=config.cart_mass_kg,
        link_kg=np.where(_IS_TELESCOPE, config.telescope_mass_kg, config.link_mass_kg),
        platform_kg=config.platform.mass_kg,
        platform_centre_m=np.array(config.platform.centre_of_mass_m),
        platform_inertia_kgm2=np.diag(config.platform.inertia_kgm2),
        load_kg=config.load_kg,
        gravity_mps2=np.array([0.0, 0.0, -config.gravity_mps2]),
        friction_n=np.array([config.friction.carts_n] * 3 + [config.friction.telescopes_n] * 2),
    )


def lumped_platform(masses: Masses, joints_m: _FLOATS) -> RigidBody:
    """Join platform, load and the halves of the links at their joints (6, 3) into one rigid body.

    By the parallel-axis theorem: I = I_p + sum m_i (|d_i|^2 1 - d_i d_i'), d_i from the common centre of mass.
    """
    m = np.concatenate([[masses.platform_kg, masses.load_kg], masses.link_kg / 2.0])
    r = np.concatenate([[masses.platform_centre_m], np.zeros((1, 3)), joints_m])
    centre = m @ r / m.sum()
    d = r - centre
    spread = np.einsum("i,ij,ij->", m, d, d) * np.eye(3) - np.einsum("i,ij,ik->jk", m, d, d)
    return RigidBody(float(m.sum()), centre, masses.platform_inertia_kgm2 + spread)
