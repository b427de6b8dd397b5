"""Keyframes for MuJoCo: an MJCF fragment with a key per period, to be included in a model of the five actuators.

The model's first five coordinates have to be sliding joints in the order c1, c2, c3, l2b, l3b; a model with more of
them needs keys of its own. All digits of every number are written.
"""

import xml.etree.ElementTree as ElementTree

import numpy as np

from pipeline.export.motion import Motion


def format_keyframes(motion: Motion) -> str:
    """Write a key for every row: time, positions and velocities.

    Raises
    ------
    ValueError
        When the motion has no velocities.
    """
    if motion.qd_mps is None:
        raise ValueError("keyframes need velocities")
    keys = [
        f'    <key name="row{k}" time="{t!r}" qpos="{_row(q)}" qvel="{_row(qd)}"/>'
        for k, (t, q, qd) in enumerate(
            zip(motion.t_s.tolist(), motion.q_m.tolist(), (motion.qd_mps + 0.0).tolist(), strict=True)
        )
    ]
    return "\n".join(["<mujoco>", "  <keyframe>", *keys, "  </keyframe>", "</mujoco>"]) + "\n"


def read_keyframes(text: str) -> Motion:
    """Read the keys back.

    Raises
    ------
    ValueError
        When the text is no XML, or has no keys.
    """
    try:
        keys = ElementTree.fromstring(text).findall("./keyframe/key")
    except ElementTree.ParseError as error:
        raise ValueError(f"not an MJCF file: {error}") from None
    if not keys:
        raise ValueError("there are no keys")
    q, qd = (np.array([[float(x) for x in key.get(name, "").split()] for key in keys]) for name in ("qpos", "qvel"))
    return Motion(np.array([float(key.get("time", "nan")) for key in keys]), q, qd)


def _row(values: list[float]) -> str:
    return " ".join(repr(value) for value in values)
