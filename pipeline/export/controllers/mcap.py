"""A ROS 2 bag in MCAP: the motion as one JointTrajectory, and as a JointState per row, for playing and looking at.

`/joint_trajectory` has the message of `--format ros2`, logged at time zero. `/joint_states` has positions and
velocities of the five actuators, then the positions of the passive joints of `--format urdf`, so that a viewer with
that model shows the machine move. Neither is a topic that a controller listens to by itself: bags are played for
everybody.
"""

import io
from importlib import import_module
from types import ModuleType
from typing import Any

from pipeline.errors import UsageError
from pipeline.export.controllers.ros2 import joint_trajectory, motion_of, nanoseconds_of, stamp
from pipeline.export.models.joints import platform_angles, universal_angles
from pipeline.export.motion import Motion
from pipeline.export.request import ExportRequest, require_machine

TRAJECTORY_TOPIC, STATES_TOPIC = "/joint_trajectory", "/joint_states"
_HEADER = """\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_TRAJECTORY = f"""\
std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
{_HEADER}"""
_STATE = f"""\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_HEADER}"""


def format_mcap(request: ExportRequest) -> bytes:
    """Write the bag; times are nanoseconds since the start, lead-in included.

    Raises
    ------
    UsageError
        When the library that writes bags is not installed, or the request has no machine.
    ValueError
        When the motion is none that a joint trajectory can hold.
    """
    bag = io.BytesIO()
    writer = _library("mcap_ros2.writer").Writer(bag)
    trajectory = joint_trajectory(request.for_controller())
    for point in trajectory["points"]:
        point["effort"] = []
    schema = writer.register_msgdef("trajectory_msgs/msg/JointTrajectory", _TRAJECTORY)
    writer.write_message(TRAJECTORY_TOPIC, schema, trajectory, log_time=0)
    schema = writer.register_msgdef("sensor_msgs/msg/JointState", _STATE)
    for t, state in zip(nanoseconds_of(request).tolist(), _states(request), strict=True):
        state["header"] = {"stamp": stamp(t), "frame_id": ""}
        writer.write_message(STATES_TOPIC, schema, state, log_time=t)
    writer.finish()
    return bag.getvalue()


def _states(request: ExportRequest) -> list[dict[str, Any]]:
    machine, samples = require_machine(request), request.samples
    passive = universal_angles(machine, samples) | platform_angles(machine, samples)
    angles = list(zip(*(values.tolist() for values in passive.values()), strict=True))
    names = [*request.joint_names, *passive]
    return [
        {"name": names, "position": [*q, *others], "velocity": qd, "effort": []}
        for q, qd, others in zip(samples.q_m.tolist(), samples.qd_mps.tolist(), angles, strict=True)
    ]


def read_mcap(content: bytes) -> Motion:
    """Read the joint trajectory of a bag back.

    Raises
    ------
    ValueError
        When it is not a bag, or has no joint trajectory.
    UsageError
        When the library that reads bags is not installed.
    """
    decoder = _library("mcap_ros2.decoder").DecoderFactory()
    try:
        reader = _library("mcap.reader").make_reader(io.BytesIO(content), decoder_factories=[decoder])
        found = [message for *_, message in reader.iter_decoded_messages(topics=[TRAJECTORY_TOPIC])]
    except _library("mcap.exceptions").McapError as error:
        raise ValueError(f"not a bag: {error}") from None
    if not found:
        raise ValueError(f"there is no message on {TRAJECTORY_TOPIC}")
    (message,) = found
    stamps = [(point.time_from_start.sec, point.time_from_start.nanosec) for point in message.points]
    rows = [(point.positions, point.velocities, point.accelerations) for point in message.points]
    return motion_of(stamps, rows, message.joint_names)


def _library(module: str) -> ModuleType:
    """Import a module of mcap-ros2-support, or of mcap, which it builds on, when it is used: few need it.

    Raises
    ------
    UsageError
        When it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise UsageError(
            f"--format mcap needs the library mcap-ros2-support, which is not installed ({error.name} is missing).\n"
            "  What to change: pip install 'gantry-tau[ros]', or use --format ros2."
        ) from None
