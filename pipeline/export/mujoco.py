"""Keyframes for MuJoCo: an MJCF fragment with a key per period, to be included in a model of the five actuators.

The first five coordinates of the model have to be sliding joints in the order c1, c2, c3, l2b, l3b; a model with more
coordinates needs keys of its own. All digits of every number are written.
"""

import xml.etree.ElementTree as ElementTree

import numpy as np

from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest


def format_keyframes(request: ExportRequest) -> str:
    """Write a key for every row: time, positions and velocities."""
    samples = request.samples
    keys = [
        f'    <key name="row{k}" time="{t!r}" qpos="{_row(q)}" qvel="{_row(qd)}"/>'
        for k, (t, q, qd) in enumerate(
            zip(samples.t_s.tolist(), samples.q_m.tolist(), (samples.qd_mps + 0.0).tolist(), strict=True)
        )
    ]
    return "\n".join(["<mujoco>", "  <keyframe>", *keys, "  </keyframe>", "</mujoco>"]) + "\n"


def read_keyframes(text: str) -> Motion:
    """Read the keys back.

    Raises
    ------
    ValueError
        When the text is not XML, or has no keys.
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
