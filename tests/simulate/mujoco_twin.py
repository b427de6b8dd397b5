"""The twin once more, in MuJoCo: links on universal joints, loops closed by constraints, the same controllers.

Unlike `tests/machine/multibody.py` its links turn about axes of the room, so that it can follow a motion through all
working modes; Y first, then Z of what Y has turned. Nothing but geometry, masses and the controllers is shared with the
model under test.
"""

import mujoco
import numpy as np

from pipeline.machine import Machine
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, link_vectors, rotation
from pipeline.simulate import Drives, Motion
from pipeline.simulate.controller import controller_function, controller_start, feed_forward

_TINY = 1e-7
SLIDERS = ("cart0", "cart1", "cart2", "slide2", "slide4")


def follow_in_mujoco(machine: Machine, drives: Drives, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Follow a motion that begins at rest, once a period: actuators (n, 5) and poses' x, y, z (n, 3)."""
    model = mujoco.MjModel.from_xml_string(_xml(machine, drives, motion.period_s))
    data = mujoco.MjData(model)
    at = [model.joint(name).qposadr[0] for name in SLIDERS]
    moving = [model.joint(name).dofadr[0] for name in SLIDERS]
    data.qpos[:] = _position(machine, motion.pose[0], motion.q_m[0])
    control = controller_function(drives, motion.period_s)
    feed = feed_forward(drives, motion.middle_n, motion.middle_mps, motion.middle_mps2)
    state = controller_start(drives, motion.period_s, motion.q_m[0], motion.drive_n[0])
    q, xyz = np.empty((len(motion), 5)), np.empty((len(motion), 3))
    for row in range(len(motion)):
        q[row] = data.qpos[at]
        xyz[row] = data.qpos[-7:-4]
        reference = np.concatenate([motion.q_m[row], motion.qd_mps[row], feed[row]])
        command, state = (np.array(part).ravel() for part in control(q[row], data.qvel[moving], state, reference))
        data.ctrl[:] = command
        mujoco.mj_step(model, data)
    return q, xyz


def _xml(machine: Machine, drives: Drives, step_s: float) -> str:
    masses = machine.masses
    assert masses is not None
    bodies = []
    for arm, (y, z) in enumerate(machine.rails_m):
        links = "".join(_link(machine, drives, link) for link in np.flatnonzero(arm == ARM_OF_LINK))
        bodies.append(
            f'<body pos="{_row([0.0, y, z])}"><joint name="cart{arm}" type="slide" axis="1 0 0" {_drive(drives, arm)}/>'
            f"{_point(masses.cart_kg)}{links}</body>"
        )
    sites = "".join(f'<site name="a{k}" pos="{_row(point)}"/>' for k, point in enumerate(machine.platform_points_m))
    inertia = masses.platform_inertia_kgm2
    moments = _row([inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]])
    bodies.append(
        f'<body><freejoint/><inertial pos="{_row(masses.platform_centre_m)}" mass="{masses.platform_kg!r}" '
        f'fullinertia="{moments}"/>{sites}<body>{_point(max(masses.load_kg, _TINY))}</body></body>'
    )
    # Loops closed within two steps and nearly without give: with the default they open by millimetres.
    loops = "".join(
        f'<connect site1="t{k}" site2="a{k}" solref="{2.0 * step_s!r} 1" solimp="0.9999 0.9999 0.001"/>'
        for k in range(6)
    )
    motors = "".join(f'<motor joint="{name}"/>' for name in SLIDERS)
    return (
        f'<mujoco><option timestep="{step_s!r}" integrator="RK4" gravity="{_row(masses.gravity_mps2)}" '
        'jacobian="dense" tolerance="1e-12"/><compiler angle="radian" boundmass="0"/>'
        f"<worldbody>{''.join(bodies)}</worldbody><equality>{loops}</equality><actuator>{motors}</actuator></mujoco>"
    )


def _link(machine: Machine, drives: Drives, link: int) -> str:
    assert machine.masses is not None
    joints = '<joint type="hinge" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>'
    place, mass = f'pos="{_row(machine.cart_offsets_m[link])}"', float(machine.masses.link_kg[link])
    if link not in TELESCOPES:
        length = float(machine.lengths_m[link])
        across = mass * length**2 / 4.0
        return (
            f'<body {place}>{joints}<inertial pos="{length / 2.0!r} 0 0" mass="{mass!r}" '
            f'diaginertia="{_TINY} {across!r} {across!r}"/><site name="t{link}" pos="{length!r} 0 0"/></body>'
        )
    drive = 3 + int(np.flatnonzero(link == TELESCOPES)[0])
    return (
        f'<body {place}>{joints}{_point(mass / 2.0)}<body><joint name="slide{link}" type="slide" axis="1 0 0" '
        f'{_drive(drives, drive)}/>{_point(mass / 2.0)}<site name="t{link}"/></body></body>'
    )


def _drive(drives: Drives, k: int) -> str:
    return (
        f'frictionloss="{float(drives.dry_friction_n[k])!r}" damping="{float(drives.viscous_friction_nspm[k])!r}" '
        f'armature="{float(drives.moving_mass_kg[k])!r}" solimpfriction="0.9999 0.9999 0.001" '
        'solreffriction="0.002 1"'
    )


def _position(machine: Machine, pose: np.ndarray, q_m: np.ndarray) -> np.ndarray:
    """All coordinates for a pose (6,) and actuators (5,)."""
    vectors, found = link_vectors(machine, pose[None], q_m[None, :3])[0], []
    for arm in range(3):
        found.append(q_m[arm])
        for link in np.flatnonzero(arm == ARM_OF_LINK):
            length = np.linalg.norm(vectors[link])
            x, y, z = vectors[link] / length
            found += [np.arctan2(-z, x), np.arcsin(y), *([length] if link in TELESCOPES else [])]
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation(*pose[3:])).ravel())
    return np.concatenate([found, pose[:3], quaternion])


def _point(mass: float) -> str:
    return f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{_TINY} {_TINY} {_TINY}"/>'


def _row(values: object) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))
