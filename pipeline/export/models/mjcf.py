"""The machine for MuJoCo: bodies, joints, loops, drives, sensors, and the motion as keyframes. Needs no MuJoCo.

A tree of carts, links and telescopes (see `joints`) and a free platform; every link's tip is held to its joint on the
platform by a `connect` constraint between two sites. Constraints are as stiff as two steps of the integrator allow
(`solref`, `solimp` 0.9999): with RK4 the loops stay closed to 0.1 um; MuJoCo's own defaults open them by millimetres.
"""

import math
from xml.etree import ElementTree

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.models.bodies import link_bodies, link_name, platform_body, point_body, require_masses
from pipeline.export.models.joints import passive_rates, universal_angles, universal_joints
from pipeline.export.models.shapes import Shapes, add_meshes, add_shapes
from pipeline.export.models.xml import Element, add, axis_text, document
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest
from pipeline.machine.drawing import rail_ends
from pipeline.machine.geometry import ARM_OF_LINK, LINKS, TELESCOPES, Machine, rotation
from pipeline.machine.masses import RigidBody
from pipeline.machine.shapes.model import FrameKind
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes

_MOST_KEYS = 10_000
"""Rows of a motion that are written as keys: about 11 MB."""
_LONGEST_STEP_S = 0.001
_STIFFNESS_NPM, _DAMPING_NSPM = 1e7, 1e4
"""Gains of the position actuators: they follow a command about a millisecond late."""
_COORDINATES = {"free": (7, 6)}
"""Coordinates and velocities of a joint, if more than one."""


def format_mjcf(request: ExportRequest) -> str:
    """Write the model with a key per row: time, all coordinates and velocities, and the drives' commands.

    Raises
    ------
    UsageError
        When the machine has no masses, its joints lock on the way, or the motion has more rows than keys are written.
    """
    machine, masses = require_masses(request)
    if len(request.samples) > _MOST_KEYS:
        raise UsageError(
            f"{len(request.samples):,} rows are too many keyframes; {_MOST_KEYS:,} are written at most.\n"
            "  What to change: raise --period."
        )
    period = request.samples.period_s
    step = period / math.ceil(period / _LONGEST_STEP_S - 1e-9)
    root = Element("mujoco", model="gantry_tau")
    add(root, "compiler", angle="radian")
    add(
        root,
        "option",
        timestep=step,
        integrator="RK4",
        gravity=masses.gravity_mps2,
        jacobian="dense",
        iterations="100",
        tolerance=1e-12,
    )
    add(add(root, "default"), "geom", contype="0", conaffinity="0", rgba="0.6 0.65 0.7 1", group="1")
    meshes = add_meshes(root, machine)
    world = add(root, "worldbody")
    add(world, "light", directional="true", pos="0 0 4", dir="0.2 0.5 -1", diffuse="0.8 0.8 0.8")
    for arm in range(3):
        _add_arm(world, request, meshes, arm)
    add_shapes(world, meshes, FrameKind.FIXED)
    _add_platform(world, request, meshes)
    _add_loops(root, 2.0 * step)
    _add_drives(root, request)
    _add_keys(root, request)
    return document(root, "5-DOF Gantry-Tau; metres, radians, kilograms, newtons; coordinates of a closed assembly")


def _add_arm(world: Element, request: ExportRequest, meshes: Shapes, arm: int) -> None:
    machine, masses = require_masses(request)
    rail, travel = machine.rails_m[arm], machine.travel_m[arm]
    ends, axis = rail_ends(machine)[arm], axis_text(machine.rail_directions[arm])
    if not add_shapes(world, meshes, FrameKind.FIXED, arm + 1):
        add(world, "geom", name=f"rail_{arm + 1}", type="capsule", size=0.01, fromto=ends, rgba="0.3 0.3 0.3 1")
    cart = add(world, "body", name=f"cart_{arm + 1}", pos=[0.0, *rail])
    friction = masses.friction_n[arm]
    add(cart, "joint", name=request.joint_names[arm], type="slide", axis=axis, range=travel, frictionloss=friction)
    _add_inertial(cart, point_body(masses.cart_kg))
    if not add_shapes(cart, meshes, FrameKind.CART, arm):
        add(cart, "geom", type="box", size="0.05 0.03 0.03")
    for link in np.flatnonzero(arm == ARM_OF_LINK).tolist():
        _add_link(cart, request, meshes, link)


def _add_link(cart: Element, request: ExportRequest, meshes: Shapes, link: int) -> None:
    machine, masses = require_masses(request)
    base, rod = link_bodies(machine, masses, link)
    name = link_name(link)
    body = add(cart, "body", name=name if rod is None else f"{name}_tube", pos=machine.cart_offsets_m[link])
    for hinge, axis in zip(universal_joints(link), ("1 0 0", "0 0 1"), strict=True):
        add(body, "joint", name=hinge, type="hinge", axis=axis)
    _add_inertial(body, base)
    add(body, "site", name=f"{name}_base")
    shaped = add_shapes(body, meshes, FrameKind.LINK, link)
    if rod is None:
        length = machine.lengths_m[link]
        if not shaped:
            add(body, "geom", type="capsule", size=0.01, fromto=[[0, 0, 0], [length, 0, 0]])
        add(body, "site", name=f"{name}_tip", pos=[length, 0, 0])
        return
    k = TELESCOPES.tolist().index(link)
    stroke, drive = machine.strokes_m[k], 3 + k
    if not shaped:
        add(body, "geom", type="capsule", size=0.016, fromto=[[0, 0, 0], [0.6 * stroke[0], 0, 0]])
    tip = add(body, "body", name=name)
    names = {"name": request.joint_names[drive], "type": "slide", "axis": "1 0 0"}
    add(tip, "joint", **names, range=stroke, frictionloss=masses.friction_n[drive])
    _add_inertial(tip, rod)
    if not add_shapes(tip, meshes, FrameKind.LINK, link, rod=True):
        add(tip, "geom", type="capsule", size=0.01, fromto=[[-0.6 * stroke[0], 0, 0], [0, 0, 0]])
    add(tip, "site", name=f"{name}_tip")


def _add_platform(world: Element, request: ExportRequest, meshes: Shapes) -> None:
    machine, masses = require_masses(request)
    platform = add(world, "body", name="platform")
    add(platform, "freejoint", name="platform")
    _add_inertial(platform, platform_body(masses))
    add(platform, "site", name="tcp")
    shaped = add_shapes(platform, meshes, FrameKind.PLATFORM)
    for link, point in enumerate(machine.platform_points_m):
        add(platform, "site", name=f"platform_{LINKS[link]}", pos=point)
        if not shaped and np.linalg.norm(point) > 0.0:
            ends = [np.zeros(3), point]
            add(platform, "geom", type="capsule", size=0.012, fromto=ends, rgba="0.85 0.5 0.2 1")
    if masses.load_kg > 0.0:
        load = add(platform, "body", name="load")
        _add_inertial(load, point_body(masses.load_kg))


def _add_inertial(body: Element, rigid: RigidBody) -> None:
    inertia = rigid.inertia_kgm2[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    add(body, "inertial", pos=rigid.centre_m, mass=rigid.mass_kg, fullinertia=inertia)


def _add_loops(root: Element, time_constant_s: float) -> None:
    equality = add(root, "equality")
    for link, name in enumerate(LINKS):
        sites = {"site1": f"{link_name(link)}_tip", "site2": f"platform_{name}"}
        add(
            equality, "connect", name=f"loop_{name}", **sites, solref=[time_constant_s, 1], solimp="0.9999 0.9999 0.001"
        )


def _add_drives(root: Element, request: ExportRequest) -> None:
    machine, _ = require_masses(request)
    actuator, sensor = add(root, "actuator"), add(root, "sensor")
    for joint, limits, (push, pull) in zip(
        request.joint_names, machine.actuator_limits_m, machine.force_limits_n.T[:5].tolist(), strict=True
    ):
        gains = {"kp": _STIFFNESS_NPM, "kv": _DAMPING_NSPM, "ctrlrange": limits}
        if math.isfinite(push) and math.isfinite(pull):
            gains["forcerange"] = [-pull, push]
        add(actuator, "position", name=joint, joint=joint, **gains)
        add(sensor, "jointpos", name=f"{joint}_position", joint=joint)
        add(sensor, "jointvel", name=f"{joint}_velocity", joint=joint)
        add(sensor, "actuatorfrc", name=f"{joint}_force", actuator=joint)
    for link, name in enumerate(LINKS):
        add(sensor, "force", name=f"link_{name}_force", site=f"{link_name(link)}_base")
    for kind in ("framepos", "framequat", "framelinvel", "frameangvel"):
        add(sensor, kind, name=f"tcp_{kind.removeprefix('frame')}", objtype="site", objname="tcp")


def _add_keys(root: Element, request: ExportRequest) -> None:
    machine, samples = require_masses(request)[0], request.samples
    angles, rates = universal_angles(machine, samples), passive_rates(machine, samples)
    quaternion = _quaternions(rotation(samples.pose[:, 3], samples.pose[:, 4], samples.pose[:, 5]))
    qpos = [*_tree(machine, samples.q_m, angles), *samples.pose[:, :3].T, *quaternion.T]
    qvel = [*_tree(machine, samples.qd_mps, rates.universal), *rates.tcp_mps.T, *rates.omega_radps.T]
    keyframe = add(root, "keyframe")
    rows = zip(_key_names(request), samples.t_s, np.stack(qpos, 1), np.stack(qvel, 1), samples.q_m, strict=True)
    for name, time, position, velocity, ctrl in rows:
        add(keyframe, "key", name=name, time=time, qpos=position, qvel=velocity, ctrl=ctrl)


def _tree(machine: Machine, driven: FloatArray, universal: dict[str, FloatArray]) -> list[FloatArray]:
    """Sort values (n, 5) of the drives and those of the hinges in the order of the joints in the tree."""
    values = []
    for arm in range(len(machine.rails_m)):
        values.append(driven[:, arm])
        for link in np.flatnonzero(arm == ARM_OF_LINK).tolist():
            values += [universal[hinge] for hinge in universal_joints(link)]
            if link in TELESCOPES:
                values.append(driven[:, 3 + TELESCOPES.tolist().index(link)])
    return values


def _key_names(request: ExportRequest) -> list[str]:
    """Name the keys: start and goal, `mode_LRL_...` where a working mode begins, and the others by their rows."""
    machine, samples = require_masses(request)[0], request.samples
    modes = mode_names(working_modes(reach_along_rails(machine, samples.pose, samples.q_m[:, :3])))
    names = [
        f"mode_{mode}_row{row}" if row and mode != modes[row - 1] else f"row{row}" for row, mode in enumerate(modes)
    ]
    names[0], names[-1] = "start", "goal"
    return names


def _quaternions(R: FloatArray) -> FloatArray:
    """Compute the quaternions (w, x, y, z) of rotations (n, 3, 3), without changes of sign on the way. Shape (n, 4)."""
    from scipy.spatial.transform import Rotation

    quaternion = Rotation.from_matrix(R).as_quat(canonical=True)[:, [3, 0, 1, 2]]
    flips = np.concatenate([[1.0], np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)])
    return np.asarray(quaternion * np.cumprod(flips)[:, None], dtype=float)


def read_mjcf(text: str) -> Motion:
    """Read the motion of the driven joints back from the keys, wherever these joints are in the tree.

    Raises
    ------
    ValueError
        When the text is not XML, has no keys or drives, or keys of another size than its joints.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"not an MJCF file: {error}") from None
    keys, drives = root.findall("./keyframe/key"), [drive.get("joint", "") for drive in root.findall("./actuator/*")]
    if not keys:
        raise ValueError("there are no keys")
    places, sizes = {}, [0, 0]
    for joint in root.iter():
        if joint.tag in ("joint", "freejoint") and joint.get("name"):
            places[joint.get("name", "")] = tuple(sizes)
            widths = _COORDINATES.get("free" if joint.tag == "freejoint" else joint.get("type", ""), (1, 1))
            sizes = [size + width for size, width in zip(sizes, widths, strict=True)]
    if missing := [drive for drive in drives if drive not in places] or ([] if drives else ["any drive"]):
        raise ValueError(f"there is no joint of {', '.join(missing)}")
    tables = [
        np.array([[float(value) for value in key.get(name, "").split()] for key in keys]) for name in ("qpos", "qvel")
    ]
    if [table.shape[1] for table in tables] != sizes:
        raise ValueError(f"keys have {tables[0].shape[1]} coordinates; the joints have {sizes[0]}")
    q, qd = (table[:, [places[drive][k] for drive in drives]] for k, table in enumerate(tables))
    return Motion(np.array([float(key.get("time", "nan")) for key in keys]), q, qd, joint_names=tuple(drives))
