"""The machine once more, for MuJoCo: links as bodies of their own, loops closed by equality constraints.

A tree of carts, links on universal joints and telescopes as sliders, with a free platform; every link's tip is held to
its joint on the platform by a `connect` constraint. Links are two points of half their mass. Nothing here is shared
with the model under test but the geometry and the masses.
"""

import mujoco
import numpy as np

from pipeline.machine import Machine
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, cart_joints, link_vectors, rotation
from pipeline.machine.masses import Masses

_TINY = 1e-7
SLIDERS = ("cart0", "cart1", "cart2", "slide2", "slide4")
"""The joints that are driven, in the order of the actuators."""


class Multibody:
    """The machine assembled in a pose (6,) with carts (3,)."""

    def __init__(self, machine: Machine, masses: Masses, pose: np.ndarray, carts_m: np.ndarray) -> None:
        self._machine = machine
        vectors = link_vectors(machine, pose[None], carts_m[None])[0]
        self._lengths = np.linalg.norm(vectors, axis=1)
        self._frames = [_frame(vector) for vector in vectors]
        self.carts0 = carts_m
        self.model = mujoco.MjModel.from_xml_string(self._xml(masses, pose))
        self.data = mujoco.MjData(self.model)
        self.driven = [self.model.joint(name).dofadr[0] for name in SLIDERS]

    def _xml(self, masses: Masses, pose: np.ndarray) -> str:
        machine, parts = self._machine, []
        for arm, (y, z) in enumerate(machine.rails_m):
            links = "".join(self._link(masses, link) for link in np.flatnonzero(arm == ARM_OF_LINK))
            parts.append(
                f'<body pos="{_row([self.carts0[arm], y, z])}">'
                f'<joint name="cart{arm}" type="slide" axis="1 0 0"/>'
                f"{_point(masses.cart_kg, 0.0)}{links}</body>"
            )
        inertia = " ".join(repr(float(value)) for value in np.diag(masses.platform_inertia_kgm2))
        parts.append(
            f'<body name="platform" pos="{_row(pose[:3])}" quat="{_row(_quaternion(rotation(*pose[3:])))}"><freejoint/>'
            f'<inertial pos="{_row(masses.platform_centre_m)}" mass="{masses.platform_kg!r}" diaginertia="{inertia}"/>'
            f"<body>{_point(max(masses.load_kg, _TINY), 0.0)}</body></body>"
        )
        closures = "".join(
            f'<connect body1="tip{link}" body2="platform" anchor="{_row([self._lengths[link], 0, 0])}" '
            'solref="0.001 1" solimp="0.9999 0.9999 0.001"/>'
            for link in range(6)
        )
        return (
            f'<mujoco><option gravity="{_row(masses.gravity_mps2)}" timestep="0.0002" jacobian="dense"'
            ' integrator="RK4"/>'
            '<compiler angle="radian" boundmass="0"/>'
            f"<worldbody>{''.join(parts)}</worldbody><equality>{closures}</equality></mujoco>"
        )

    def _link(self, masses: Masses, link: int) -> str:
        length, half = float(self._lengths[link]), float(masses.link_kg[link]) / 2.0
        place = f'pos="{_row(self._machine.cart_offsets_m[link])}" quat="{_row(_quaternion(self._frames[link]))}"'
        joints = '<joint type="hinge" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>'
        if link not in TELESCOPES:
            across = half * length**2 / 2.0
            inertia = _row([_TINY, across, across])
            inertial = f'<inertial pos="{length / 2.0!r} 0 0" mass="{2.0 * half!r}" diaginertia="{inertia}"/>'
            return f'<body name="tip{link}" {place}>{joints}{inertial}</body>'
        rod = (
            f'<body name="tip{link}"><joint name="slide{link}" type="slide" axis="1 0 0"/>{_point(half, length)}</body>'
        )
        return f"<body {place}>{joints}{_point(half, 0.0)}{rod}</body>"

    def position(self, pose: np.ndarray, q_m: np.ndarray) -> np.ndarray:
        """Coordinates of all joints for a pose (6,) and actuators (5,)."""
        joints = cart_joints(self._machine, q_m[None, :3])[0]
        vectors = link_vectors(self._machine, pose[None], q_m[None, :3])[0]
        assert np.allclose(joints + vectors, pose[:3] + self._machine.platform_points_m @ rotation(*pose[3:]).T)
        found = []
        for arm in range(3):
            found.append(q_m[arm] - self.carts0[arm])
            for link in np.flatnonzero(arm == ARM_OF_LINK):
                x, y, z = self._frames[link].T @ vectors[link]
                found += [np.arctan2(y, x), -np.arctan2(z, np.hypot(x, y))]
                if link in TELESCOPES:
                    found.append(np.linalg.norm(vectors[link]) - self._lengths[link])
        return np.concatenate([found, pose[:3], _quaternion(rotation(*pose[3:]))])

    def inverse(self, positions: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Forces of drives (5,) and of the tips on the platform (6, 3), for five positions h apart, at the middle one.

        M a + bias = S' tau + J' lambda, solved for tau and lambda.
        """
        model, data = self.model, self.data

        def difference(before: np.ndarray, after: np.ndarray) -> np.ndarray:
            velocity = np.zeros(model.nv)
            mujoco.mj_differentiatePos(model, velocity, 1.0, before, after)
            return velocity

        one, two = difference(positions[1], positions[3]), difference(positions[0], positions[4])
        data.qpos, data.qvel = positions[2], (8.0 * one - two) / (12.0 * h)
        late, early = difference(positions[2], positions[3]), difference(positions[1], positions[2])
        acceleration = (late - early) / h**2
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        J = data.efc_J.reshape(-1, model.nv)[: 3 * 6]
        S = np.zeros((5, model.nv))
        S[np.arange(5), self.driven] = 1.0
        solution, *_ = np.linalg.lstsq(np.vstack([S, J]).T, M @ acceleration + data.qfrc_bias, rcond=None)
        return solution[:5], -solution[5:].reshape(6, 3)


def _point(mass: float, along_m: float) -> str:
    return f'<inertial pos="{along_m!r} 0 0" mass="{mass!r}" diaginertia="{_TINY} {_TINY} {_TINY}"/>'


def _frame(direction: np.ndarray) -> np.ndarray:
    """A rotation whose x axis has this direction."""
    x = direction / np.linalg.norm(direction)
    z = np.cross(x, [0.0, 1.0, 0.0])
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _quaternion(R: np.ndarray) -> np.ndarray:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(R).ravel())
    return quaternion


def _row(values: object) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))
