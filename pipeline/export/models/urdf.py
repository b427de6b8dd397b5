"""The machine as URDF, which knows trees only: the spanning tree, and in a YAML file beside it the loops.

The tree has carts, links and telescopes (see `joints`); the platform hangs on link 1. The five other links close loops:
two frames each, at the link's tip and at its joint on the platform, that have to be at one point. The YAML file lists
them under the keys of the Extended URDF (`closed_loop`, `type`, `name_mot`), and has a closed assembly to begin from.
"""

import math

import numpy as np
import numpy.typing as npt
import yaml

from pipeline.arrays import FloatArray
from pipeline.export.models.bodies import link_bodies, link_name, platform_body, point_body, require_masses
from pipeline.export.models.joints import (
    CARRIER,
    PLATFORM_JOINTS,
    platform_angles,
    universal_angles,
    universal_joints,
)
from pipeline.export.models.xml import Element, add, axis_text, document
from pipeline.export.request import ExportRequest
from pipeline.machine.drawing import rail_ends
from pipeline.machine.geometry import ARM_OF_LINK, LINKS, TELESCOPES
from pipeline.machine.masses import RigidBody

_TURN = 2.0 * math.pi
_UNLIMITED = 1e6
"""What is written where there is no limit of force or velocity: URDF wants a number."""
_ALONG_X = "0 1.5707963267948966 0"
"""Turns a cylinder from z to x."""


def format_urdf(request: ExportRequest) -> str:
    """Write the spanning tree; what it looks like are boxes and cylinders, and nothing collides.

    Raises
    ------
    UsageError
        When the machine has no masses.
    """
    machine, masses = require_masses(request)
    robot = Element("robot", name="gantry_tau")
    base = add(robot, "link", name="base")
    for arm, ends in enumerate(rail_ends(machine)):
        along = machine.rail_directions[arm]
        _add_rod(base, float(np.ptp(machine.travel_m[arm])), ends[0], 0.01, along)
    for arm in range(3):
        cart = _add_body(robot, f"cart_{arm + 1}", point_body(masses.cart_kg))
        add(add(add(cart, "visual"), "geometry"), "box", size="0.1 0.06 0.06")
        _add_drive(robot, request, arm, ("base", f"cart_{arm + 1}"), [0.0, *machine.rails_m[arm]])
        for link in np.flatnonzero(arm == ARM_OF_LINK).tolist():
            _add_link(robot, request, link)
    _add_platform(robot, request)
    return document(robot, "5-DOF Gantry-Tau, spanning tree; the loops are in the .yaml file beside this one")


def format_loops(request: ExportRequest) -> str:
    """Write the loops, the driven joints, gravity, and all joints of the assembly that the motion begins with.

    Raises
    ------
    UsageError
        When the machine has no masses, or a joint locks on the way.
    """
    machine, masses = require_masses(request)
    samples = request.samples
    joints = dict(zip(request.joint_names, samples.q_m.T, strict=True))
    joints |= universal_angles(machine, samples) | platform_angles(machine, samples)
    loops = [[_tip(link), f"platform_{name}"] for link, name in enumerate(LINKS) if link != CARRIER]
    content = {
        "closed_loop": loops,
        "type": ["3d"] * len(loops),
        "name_mot": list(request.joint_names),
        "joint_name": [],
        "joint_type": [],
        "gravity_mps2": masses.gravity_mps2.tolist(),
        "start": {name: float(values[0]) for name, values in joints.items()},
    }
    return (
        "# Loops that close the tree of the URDF file; positions at the start in metres and radians.\n"
        + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
    )


def _add_link(robot: Element, request: ExportRequest, link: int) -> None:
    machine, masses = require_masses(request)
    base, rod = link_bodies(machine, masses, link)
    cart, name = f"cart_{ARM_OF_LINK[link] + 1}", link_name(link)
    body = name if rod is None else f"{name}_tube"
    about, square = universal_joints(link)
    _add_body(robot, f"{name}_gimbal", None)
    _add_hinge(robot, about, (cart, f"{name}_gimbal"), "1 0 0", machine.cart_offsets_m[link])
    shape = _add_body(robot, body, base)
    _add_hinge(robot, square, (f"{name}_gimbal", body), "0 0 1")
    if rod is None:
        length = float(machine.lengths_m[link])
        _add_rod(shape, length, [0.0, 0.0, 0.0], 0.01)
        tip = np.array([length, 0.0, 0.0])
    else:
        drive = 3 + TELESCOPES.tolist().index(link)
        half = 0.6 * float(machine.strokes_m[drive - 3, 0])
        _add_rod(shape, half, [0.0, 0.0, 0.0], 0.016)
        _add_rod(_add_body(robot, name, rod), half, [-half, 0.0, 0.0], 0.01)
        _add_drive(robot, request, drive, (body, name), [0.0, 0.0, 0.0])
        tip = np.zeros(3)
    _add_frame(robot, name, _tip(link), tip)


def _add_platform(robot: Element, request: ExportRequest) -> None:
    machine, masses = require_masses(request)
    parent = _tip(CARRIER)
    for joint, axis in zip(PLATFORM_JOINTS[:2], ("0 0 1", "0 1 0"), strict=True):
        _add_body(robot, f"{joint}_gimbal", None)
        _add_hinge(robot, joint, (parent, f"{joint}_gimbal"), axis)
        parent = f"{joint}_gimbal"
    # The last hinge turns a frame at the joint of link 1; the platform's own frame is at the TCP.
    _add_body(robot, f"platform_{LINKS[CARRIER]}", None)
    _add_hinge(robot, PLATFORM_JOINTS[2], (parent, f"platform_{LINKS[CARRIER]}"), "1 0 0")
    platform = _add_body(robot, "platform", platform_body(masses))
    add(add(add(platform, "visual"), "geometry"), "sphere", radius="0.02")
    _add_fixed(robot, f"platform_{LINKS[CARRIER]}", "platform", -machine.platform_points_m[CARRIER])
    for link, point in enumerate(machine.platform_points_m):
        if link != CARRIER:
            _add_frame(robot, "platform", f"platform_{LINKS[link]}", point)
    if masses.load_kg > 0.0:
        _add_body(robot, "load", point_body(masses.load_kg))
        _add_fixed(robot, "platform", "load", np.zeros(3))


def _tip(link: int) -> str:
    return f"{link_name(link)}_tip"


def _add_body(robot: Element, name: str, body: RigidBody | None) -> Element:
    link = add(robot, "link", name=name)
    if body is not None:
        inertial = add(link, "inertial")
        add(inertial, "origin", xyz=body.centre_m, rpy="0 0 0")
        add(inertial, "mass", value=body.mass_kg)
        entries = {f"i{a}{b}": body.inertia_kgm2[i, j] for (i, a), (j, b) in _UPPER}
        add(inertial, "inertia", **entries)
    return link


_AXES = tuple(enumerate("xyz"))
_UPPER = tuple((one, two) for one in _AXES for two in _AXES if one <= two)


def _add_rod(
    link: Element, length_m: float, start_m: npt.ArrayLike, radius_m: float, along: FloatArray | None = None
) -> None:
    visual = add(link, "visual")
    x, y, z = direction = np.array([1.0, 0.0, 0.0]) if along is None else along
    middle = np.asarray(start_m) + direction * (length_m / 2.0)
    turns = _ALONG_X if y == z == 0.0 else [0.0, float(np.arccos(z)), float(np.arctan2(y, x))]
    add(visual, "origin", xyz=middle, rpy=turns)
    add(add(visual, "geometry"), "cylinder", radius=radius_m, length=length_m)


def _add_joint(robot: Element, name: str, kind: str, bodies: tuple[str, str], origin_m: FloatArray) -> Element:
    joint = add(robot, "joint", name=name, type=kind)
    add(joint, "origin", xyz=origin_m, rpy="0 0 0")
    add(joint, "parent", link=bodies[0])
    add(joint, "child", link=bodies[1])
    return joint


def _add_fixed(robot: Element, parent: str, child: str, origin_m: FloatArray) -> None:
    _add_joint(robot, f"{child}_fixed", "fixed", (parent, child), origin_m)


def _add_frame(robot: Element, parent: str, name: str, origin_m: FloatArray) -> None:
    _add_body(robot, name, None)
    _add_fixed(robot, parent, name, origin_m)


def _add_hinge(
    robot: Element, name: str, bodies: tuple[str, str], axis: str, origin_m: FloatArray | None = None
) -> None:
    joint = _add_joint(robot, name, "revolute", bodies, np.zeros(3) if origin_m is None else origin_m)
    add(joint, "axis", xyz=axis)
    add(joint, "limit", lower=-_TURN, upper=_TURN, effort=0.0, velocity=_UNLIMITED)


def _add_drive(
    robot: Element, request: ExportRequest, drive: int, bodies: tuple[str, str], origin_m: list[float]
) -> None:
    machine, masses = require_masses(request)
    joint = _add_joint(robot, request.joint_names[drive], "prismatic", bodies, np.array(origin_m))
    lower, upper = machine.actuator_limits_m[drive]
    effort, velocity = machine.force_limits_n[:, drive].max(), machine.velocity_mps[drive]
    along = machine.rail_directions[drive] if drive < len(machine.rails_m) else np.array([1.0, 0.0, 0.0])
    add(joint, "axis", xyz=axis_text(along))
    limits = {"effort": min(effort, _UNLIMITED), "velocity": min(velocity, _UNLIMITED)}
    add(joint, "limit", lower=lower, upper=upper, **limits)
    add(joint, "dynamics", damping=0.0, friction=masses.friction_n[drive])
