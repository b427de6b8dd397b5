"""Bags for ROS 2, read by programs that nobody here wrote."""

import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import UsageError
from pipeline.export import ExportOptions, ExportRequest
from pipeline.export.controllers.mcap import STATES_TOPIC, TRAJECTORY_TOPIC, format_mcap, read_mcap
from pipeline.export.models.joints import PLATFORM_JOINTS
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])


@pytest.fixture(scope="module")
def bag(reference: TrajectorySamples, machine: Machine) -> bytes:
    """The reference motion, half a second later."""
    pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed: pip install '.[ros]'")
    return format_mcap(ExportRequest(reference, LIMITS, ACTUATORS, ExportOptions(lead_in_s=0.5), machine))


@pytest.mark.parametrize("store", ["ROS2_FOXY", "ROS2_HUMBLE", "ROS2_JAZZY", "LATEST"])
def test_rosbags_reads_it_bit_for_bit(
    bag: bytes, reference: TrajectorySamples, machine: Machine, tmp_path: Path, store: str
) -> None:
    """Its types of several ROS releases, from its own definitions, give every value back and write the same bytes."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed: pip install '.[consumers]'")
    typesys = pytest.importorskip("rosbags.typesys")
    types = typesys.get_typestore(typesys.Stores[store])
    file = tmp_path / "motion.mcap"
    file.write_bytes(bag)
    q, qd, times, names = [], [], [], ()
    with rosbag2.Reader(file) as reader:
        assert {one.topic: one.msgtype for one in reader.connections} == {
            TRAJECTORY_TOPIC: "trajectory_msgs/msg/JointTrajectory",
            STATES_TOPIC: "sensor_msgs/msg/JointState",
        }
        for connection, logged, raw in reader.messages():
            message = types.deserialize_cdr(raw, connection.msgtype)
            assert bytes(types.serialize_cdr(message, connection.msgtype)) == bytes(raw)
            if connection.topic == STATES_TOPIC:
                times.append(logged)
                q.append(message.position)
                qd.append(message.velocity)
                names = tuple(message.name)
            else:
                assert logged == 0
                assert tuple(message.joint_names) == ACTUATORS
                assert np.array([point.positions for point in message.points]).tolist() == reference.q_m.tolist()
    assert names[:5] == ACTUATORS
    assert names[-3:] == PLATFORM_JOINTS
    assert np.array(q)[:, :5].tolist() == reference.q_m.tolist()
    assert np.array(qd).tolist() == reference.qd_mps.tolist()
    assert np.array(times) / 1e9 == pytest.approx(reference.t_s + 0.5, abs=1e-9)


def test_it_is_the_same_every_time(bag: bytes, reference: TrajectorySamples, machine: Machine) -> None:
    """No clock gets into the file."""
    assert format_mcap(ExportRequest(reference, LIMITS, ACTUATORS, ExportOptions(lead_in_s=0.5), machine)) == bag


def test_what_is_no_bag_is_refused(bag: bytes) -> None:
    """Other bytes, and a bag cut short."""
    for content in (b"points: 3", bag[:100]):
        with pytest.raises(ValueError, match=r"not a bag|no message on"):
            read_mcap(content)


def test_without_the_library_the_message_says_what_to_install(
    make_samples, machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is an optional dependency."""
    for module in ("mcap_ros2", "mcap_ros2.writer"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(UsageError, match=r"mcap-ros2-support, which is not installed.*\n.*gantry-tau\[ros\]"):
        format_mcap(ExportRequest(make_samples(0.01), LIMITS, ACTUATORS, machine=machine))
