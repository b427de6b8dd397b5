"""A trajectory_msgs/JointTrajectory message, as YAML or JSON, and back.

Field names and their meaning are those of the message's definition: joint_names, and points with positions,
velocities, accelerations and time_from_start in whole seconds and nanoseconds, strictly increasing.
"""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml

from pipeline.export.motion import Motion

_NANO = 1_000_000_000


def joint_trajectory(motion: Motion, joint_names: Sequence[str]) -> dict[str, Any]:
    """Build the message as plain values; the last point has no velocity, as controllers insist on.

    Raises
    ------
    ValueError
        When times do not increase from one nanosecond to the next, or the motion does not end at rest.
    """
    nanoseconds = np.rint(motion.t_s * _NANO).astype(np.int64)
    if not (np.diff(nanoseconds) > 0).all():
        raise ValueError("time_from_start has to increase strictly")
    if motion.qd_mps is None or motion.qdd_mps2 is None or motion.qd_mps[-1].any():
        raise ValueError("a joint trajectory needs velocities and accelerations, and ends at rest")
    points = [
        {
            "positions": q,
            "velocities": qd,
            "accelerations": qdd,
            "time_from_start": {"sec": t // _NANO, "nanosec": t % _NANO},
        }
        for t, q, qd, qdd in zip(
            nanoseconds.tolist(),
            motion.q_m.tolist(),
            (motion.qd_mps + 0.0).tolist(),
            (motion.qdd_mps2 + 0.0).tolist(),
            strict=True,
        )
    ]
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "joint_names": list(joint_names), "points": points}


def format_json(motion: Motion, joint_names: Sequence[str]) -> str:
    """Write the message as JSON, one point per line, all digits of every number."""
    message = joint_trajectory(motion, joint_names)
    points = ",\n".join(json.dumps(point) for point in message.pop("points"))
    return json.dumps(message)[:-1] + ', "points": [\n' + points + "\n]}\n"


def format_yaml(motion: Motion, joint_names: Sequence[str]) -> str:
    """Write the message as YAML, one point per line; JSON's flow style is YAML, too."""
    message = joint_trajectory(motion, joint_names)
    head = "".join(f"{key}: {json.dumps(value)}\n" for key, value in message.items() if key != "points")
    return head + "points:\n" + "".join(f"- {_flow(point)}\n" for point in message["points"])


def read_joint_trajectory(text: str) -> tuple[Motion, tuple[str, ...]]:
    """Read a message from YAML or JSON: the motion, and the names of the joints.

    Raises
    ------
    ValueError
        When it is no joint trajectory.
    """
    try:
        message = json.loads(text) if text.lstrip().startswith("{") else yaml.load(text, Loader=_LOADER)
        points = message["points"]
        stamps = [point["time_from_start"] for point in points]
        t = np.array([stamp["sec"] + stamp["nanosec"] / _NANO for stamp in stamps])
        q, qd, qdd = (
            np.array([point[name] for point in points], dtype=float)
            for name in ("positions", "velocities", "accelerations")
        )
        return Motion(t, q, qd, qdd), tuple(message["joint_names"])
    except (KeyError, TypeError, yaml.YAMLError, json.JSONDecodeError) as error:
        raise ValueError(f"not a joint trajectory: {error}") from None


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _flow(point: dict[str, Any]) -> str:
    """Write a point in flow style: YAML 1.1 reads numbers such as 1e-05 as words unless they have a point."""
    numbers = {name: values for name, values in point.items() if name != "time_from_start"}
    parts = [f"{name}: [{', '.join(_number(value) for value in values)}]" for name, values in numbers.items()]
    stamp = point["time_from_start"]
    return "{" + ", ".join([*parts, f"time_from_start: {{sec: {stamp['sec']}, nanosec: {stamp['nanosec']}}}"]) + "}"


def _number(value: float) -> str:
    text = repr(value)
    if "e" in text and "." not in text:
        return text.replace("e", ".0e")
    return text
