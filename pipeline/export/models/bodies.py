"""The rigid bodies of a model: masses and inertias as in the machine's dynamics, half of every link at each end."""

from typing import NamedTuple

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.models.joints import PASSIVE_JOINTS
from pipeline.export.request import ExportRequest, require_machine
from pipeline.machine.geometry import LINKS, TELESCOPES, Machine
from pipeline.machine.masses import Masses, RigidBody

_POINT_KGM2 = 1e-9
"""Inertia of a point of mass: engines want some, about every axis."""
_LEAST_KG = 1e-9
"""Mass of what has none."""


class LinkBodies(NamedTuple):
    """The bodies of a link, in a frame with its x axis along the link: one, or tube and rod of a telescope.

    The frame of the base is at the joint on the cart, that of the rod at its tip.
    """

    base: RigidBody
    rod: RigidBody | None


def require_masses(request: ExportRequest) -> tuple[Machine, Masses]:
    """Return machine and masses of a request.

    Raises
    ------
    UsageError
        When there are none, or a drive is called as a passive joint of the model.
    """
    machine = require_machine(request)
    if taken := sorted(set(request.joint_names) & PASSIVE_JOINTS):
        raise UsageError(
            f"{', '.join(taken)} is the name of a passive joint of the model.\n  What to change: export.joint_names."
        )
    if machine.masses is None:
        raise UsageError(
            "a model of the machine needs masses, and the configuration of this run has none.\n"
            "  What to change: give machine.dynamics, and run again."
        )
    return machine, machine.masses


def point_body(mass_kg: float, along_m: float = 0.0) -> RigidBody:
    """Make a point of mass on the x axis."""
    return RigidBody(max(mass_kg, _LEAST_KG), np.array([along_m, 0.0, 0.0]), _POINT_KGM2 * np.eye(3))


def link_bodies(machine: Machine, masses: Masses, link: int) -> LinkBodies:
    """Make the bodies of a link: two points of half its mass, which about its middle have the inertia m L^2 / 4."""
    mass = float(masses.link_kg[link])
    if link in TELESCOPES:
        return LinkBodies(point_body(mass / 2.0), point_body(mass / 2.0))
    length = float(machine.lengths_m[link])
    whole = point_body(mass, length / 2.0)
    return LinkBodies(RigidBody(whole.mass_kg, whole.centre_m, whole.inertia_kgm2 + _across(mass, length)), None)


def platform_body(masses: Masses) -> RigidBody:
    """Make the platform with its tool, without load and links."""
    return RigidBody(masses.platform_kg, masses.platform_centre_m, masses.platform_inertia_kgm2)


def link_name(link: int) -> str:
    """Name a link's body: of a telescope the rod, which ends at the platform."""
    return f"link_{LINKS[link]}"


def _across(mass_kg: float, length_m: float) -> FloatArray:
    return np.diag([0.0, 1.0, 1.0]) * mass_kg * length_m**2 / 4.0
