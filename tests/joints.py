"""Cones of joints for the reference machine, at both ends of links of fixed length and of telescopes."""

from dataclasses import replace

import numpy as np

from pipeline.machine import Machine
from pipeline.machine.geometry import LINKS
from pipeline.machine.joints.cone import JointCone

CONES = {
    "machine.links.l2a.platform_cone": {"axis": [0.0, 1.98, -0.28], "half_angle_deg": 105.0},
    "machine.links.l2b.platform_cone": {"axis": [0.0, 0.99, -0.14], "half_angle_deg": 105.0},
    "machine.links.l3a.cart_cone": {"axis": [0.0, 0.41, 0.91], "half_angle_deg": 52.0},
    "machine.links.l3b.cart_cone": {"axis": [0.0, 0.41, 0.91], "half_angle_deg": 54.0},
}
"""Changes for `vary`. On the coarse grids the reference route is not within these."""


def cone(link: str, end: str, axis: tuple[float, float, float], half_angle_deg: float) -> JointCone:
    """Give a link, "2a", a cone at its "platform" or "cart" joint."""
    unit = np.array(axis) / np.linalg.norm(axis)
    key = f"machine.links.l{link}.{end}_cone"
    return JointCone(LINKS.index(link), end == "platform", unit, half_angle_deg, key)


def every_cone(half_angle_deg: float) -> tuple[JointCone, ...]:
    """Give all twelve joints cones about different axes."""
    axes = np.random.default_rng(5).normal(size=(12, 3))
    ends = [(link, end) for link in LINKS for end in ("platform", "cart")]
    return tuple(cone(link, end, axis, half_angle_deg) for (link, end), axis in zip(ends, axes, strict=True))


def with_cones(machine: Machine, *cones: JointCone) -> Machine:
    """Give a machine these cones."""
    return replace(machine, joint_cones=cones)
