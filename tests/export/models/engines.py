"""The exported machine in two simulators that know nothing of this project: poses, and the drives' forces by theirs.

Both find velocities and accelerations of all joints from those of the drives and the closures, J v = 0 and
J a + J' v = 0, and the drives' forces from M a + bias = S' tau + J' lambda, solved by the motions that closures allow.
"""

from typing import Any, NamedTuple

import numpy as np
import yaml

LINKS = ("1", "2a", "2b", "3a", "3b", "3c")


class Answer(NamedTuple):
    """TCP (n, 3) in metres, rotation of the platform (n, 3, 3), drive forces (n, 5) and widest gap of a loop."""

    tcp_m: np.ndarray
    R: np.ndarray
    drive_n: np.ndarray
    gap_m: float


def ask_mujoco(text: str, qdd: np.ndarray) -> Answer:
    """Load an MJCF file, and evaluate its keys with accelerations (n, 5) of the drives."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    driven = [int(model.joint(model.actuator(k).trnid[0]).dofadr[0]) for k in range(model.nu)]
    passive = np.setdiff1d(np.arange(model.nv), driven)
    tcp, R, tau, gaps = [], [], [], []
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_forward(model, data)
        J, drift = np.zeros((18, model.nv)), np.zeros(18)
        for loop in range(6):
            for sign, site in ((1.0, model.eq_obj1id[loop]), (-1.0, model.eq_obj2id[loop])):
                by, by_rate, rows = np.zeros((3, model.nv)), np.zeros((3, model.nv)), slice(3 * loop, 3 * loop + 3)
                body, point = model.site_bodyid[site], data.site_xpos[site]
                mujoco.mj_jacSite(model, data, by, None, site)
                mujoco.mj_jacDot(model, data, by_rate, None, point, body)
                J[rows] += sign * by
                drift[rows] += sign * by_rate @ data.qvel
            ends = data.site_xpos[[model.eq_obj1id[loop], model.eq_obj2id[loop]]]
            gaps.append(np.linalg.norm(ends[0] - ends[1]))
        acceleration = np.zeros(model.nv)
        acceleration[driven] = qdd[key]
        acceleration[passive] = np.linalg.solve(J[:, passive], -drift - J[:, driven] @ qdd[key])
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        tau.append(_project(J, driven, passive, M @ acceleration + data.qfrc_bias))
        tcp.append(data.site("tcp").xpos.copy())
        R.append(data.site("tcp").xmat.reshape(3, 3).copy())
    return Answer(np.array(tcp), np.array(R), np.array(tau), max(gaps))


def ask_pinocchio(text: str, loops: str, joints: dict[str, np.ndarray], qd: np.ndarray, qdd: np.ndarray) -> Answer:
    """Load a URDF file and its loops, and evaluate positions (n,) of all joints with motions (n, 5) of the drives."""
    import pinocchio as pin

    model = pin.buildModelFromXML(text)
    data: Any = model.createData()
    described = yaml.safe_load(loops)
    model.gravity.linear = np.array(described["gravity_mps2"])
    pairs = [[model.getFrameId(name) for name in pair] for pair in described["closed_loop"]]
    driven = [model.joints[model.getJointId(name)].idx_v for name in described["name_mot"]]
    passive = np.setdiff1d(np.arange(model.nv), driven)
    rows = np.stack([joints[name] for name in model.names[1:]], axis=1)
    world, platform = pin.LOCAL_WORLD_ALIGNED, model.getFrameId("platform")
    tcp, R, tau, gaps = [], [], [], []
    for q, v_driven, a_driven in zip(rows, qd, qdd, strict=True):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J = np.vstack(
            [
                (pin.getFrameJacobian(model, data, one, world) - pin.getFrameJacobian(model, data, two, world))[:3]
                for one, two in pairs
            ]
        )
        v, a = np.zeros(model.nv), np.zeros(model.nv)
        v[driven], a[driven] = v_driven, a_driven
        v[passive] = np.linalg.solve(J[:, passive], -J[:, driven] @ v_driven)
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        pin.updateFramePlacements(model, data)
        drift = np.concatenate(
            [
                (
                    pin.getFrameClassicalAcceleration(model, data, one, world)
                    - pin.getFrameClassicalAcceleration(model, data, two, world)
                ).linear
                for one, two in pairs
            ]
        )
        a[passive] = np.linalg.solve(J[:, passive], -drift - J[:, driven] @ a_driven)
        gaps += [np.linalg.norm(data.oMf[one].translation - data.oMf[two].translation) for one, two in pairs]
        tcp.append(data.oMf[platform].translation.copy())
        R.append(data.oMf[platform].rotation.copy())
        tau.append(_project(J, driven, passive, pin.rnea(model, data, q, v, a)))
    return Answer(np.array(tcp), np.array(R), np.array(tau), max(gaps))


def _project(J: np.ndarray, driven: list[int], passive: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Forces of all joints as forces of the drives: T' f with T = [1; -J_p^-1 J_d]."""
    return forces[driven] - J[:, driven].T @ np.linalg.solve(J[:, passive].T, forces[passive])
