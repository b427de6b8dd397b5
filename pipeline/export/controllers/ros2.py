"""A trajectory_msgs/JointTrajectory message, as YAML or JSON, and back.

Fields are those of the message's definition: joint_names, and points with positions, velocities, accelerations and a
strictly increasing time_from_start in whole seconds and nanoseconds. With a lead-in all points are later by it, and
the controller has that time to reach the first one; without, it commands the first point wherever the machine is.
"""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml

from pipeline.arrays import IntArray
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest

_NANO = 1_000_000_000


def joint_trajectory(request: ExportRequest) -> dict[str, Any]:
    """Build the message as plain values; the velocities of the last point are zero, as controllers require.

    Raises
    ------
    ValueError
        When times do not increase by at least a nanosecond, or the motion does not end at rest.
    """
    samples = request.samples
    nanoseconds = nanoseconds_of(request)
    if not (np.diff(nanoseconds) > 0).all():
        raise ValueError("time_from_start has to increase strictly")
    if samples.qd_mps[-1].any():
        raise ValueError("a joint trajectory has to end at rest")
    points = [
        {
            "positions": q,
            "velocities": qd,
            "accelerations": qdd,
            "time_from_start": stamp(t),
        }
        for t, q, qd, qdd in zip(
            nanoseconds.tolist(),
            samples.q_m.tolist(),
            (samples.qd_mps + 0.0).tolist(),
            (samples.qdd_mps2 + 0.0).tolist(),
            strict=True,
        )
    ]
    header = {"stamp": stamp(0), "frame_id": ""}
    return {"header": header, "joint_names": list(request.joint_names), "points": points}


def stamp(nanoseconds: int) -> dict[str, int]:
    """Split a time into whole seconds and nanoseconds."""
    return {"sec": nanoseconds // _NANO, "nanosec": nanoseconds % _NANO}


def nanoseconds_of(request: ExportRequest) -> IntArray:
    """Compute the times of the points (n,), lead-in included, in nanoseconds."""
    return np.rint((request.samples.t_s + request.options.lead_in_s) * _NANO).astype(np.int64)


def format_json(request: ExportRequest) -> str:
    """Write the message as JSON, one point per line, with all digits of every number."""
    message = joint_trajectory(request)
    points = ",\n".join(json.dumps(point) for point in message.pop("points"))
    return json.dumps(message)[:-1] + ', "points": [\n' + points + "\n]}\n"


def format_yaml(request: ExportRequest) -> str:
    """Write the message as YAML, one point per line; JSON is valid YAML, too."""
    message = joint_trajectory(request)
    head = "".join(f"{key}: {json.dumps(value)}\n" for key, value in message.items() if key != "points")
    return head + "points:\n" + "".join(f"- {_flow(point)}\n" for point in message["points"])


def read_joint_trajectory(text: str) -> Motion:
    """Read a message from YAML or JSON: the motion, and the names of the joints.

    Raises
    ------
    ValueError
        When it is not a joint trajectory.
    """
    try:
        message = json.loads(text) if text.lstrip().startswith("{") else yaml.load(text, Loader=_LOADER)
        points = message["points"]
        stamps = [(point["time_from_start"]["sec"], point["time_from_start"]["nanosec"]) for point in points]
        rows = [tuple(point[name] for name in ("positions", "velocities", "accelerations")) for point in points]
        return motion_of(stamps, rows, message["joint_names"])
    except (KeyError, TypeError, yaml.YAMLError, json.JSONDecodeError) as error:
        raise ValueError(f"not a joint trajectory: {error}") from None


def motion_of(stamps: Sequence[tuple[int, int]], rows: Sequence[tuple[Any, ...]], names: Sequence[str]) -> Motion:
    """Build the motion from times in seconds and nanoseconds, and rows of positions, velocities, accelerations."""
    q, qd, qdd = np.array(rows, dtype=float).swapaxes(0, 1)
    return Motion(np.array([sec + nanosec / _NANO for sec, nanosec in stamps]), q, qd, qdd, tuple(names))


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def _flow(point: dict[str, Any]) -> str:
    """Write a point in flow style: YAML 1.1 reads numbers such as 1e-05 as text unless they have a decimal point."""
    numbers = {name: values for name, values in point.items() if name != "time_from_start"}
    parts = [f"{name}: [{', '.join(_number(value) for value in values)}]" for name, values in numbers.items()]
    stamp = point["time_from_start"]
    return "{" + ", ".join([*parts, f"time_from_start: {{sec: {stamp['sec']}, nanosec: {stamp['nanosec']}}}"]) + "}"


def _number(value: float) -> str:
    text = repr(value)
    if "e" in text and "." not in text:
        return text.replace("e", ".0e")
    return text
