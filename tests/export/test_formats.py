"""Every format comes back as the motion it was written from, within its own precision, at every period."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import yaml

from pipeline.errors import UsageError
from pipeline.export import (
    ExportOptions,
    ExportRequest,
    Motion,
    export_files,
    format_halstreamer,
    format_samples,
    format_yaml,
    needed_decimals,
    read_beckhoff,
    read_csv,
    read_halstreamer,
    read_joint_trajectory,
    read_mjcf,
    read_motion,
    read_trajectory_csv,
)
from pipeline.export.controllers.cam import read_cam
from pipeline.export.controllers.pvt import read_pvt
from pipeline.export.formats import AngleUnit, DecimalMark, Format, LengthUnit, Separator, Times
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])
PERIODS = [0.000125, 0.001, 0.004, 0.01, 0.1]
MOTIONS = [kind for kind in Format if kind.reader]


@pytest.fixture
def written_and_read(make_samples, machine: Machine) -> Callable[..., tuple[TrajectorySamples, Motion]]:
    """Give a function that writes a format at a period, and reads it back; cams keep every point."""

    def both(kind: Format, period_s: float) -> tuple[TrajectorySamples, Motion]:
        if kind is Format.MCAP:
            pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
        options = ExportOptions(tolerance_m=0.0) if kind is Format.CAM else ExportOptions()
        samples = make_samples(period_s)
        content = export_files(kind, ExportRequest(samples, LIMITS, ACTUATORS, options, machine))[""]
        return samples, read_motion(kind, content if kind is Format.MCAP else content.decode())

    return both


@pytest.mark.parametrize("period_s", PERIODS)
@pytest.mark.parametrize("kind", MOTIONS)
def test_every_format_reads_back(written_and_read, kind: Format, period_s: float) -> None:
    """Times to a nanosecond, values to half of the last decimal, whatever a format has of them."""
    samples, motion = written_and_read(kind, period_s)
    assert motion.t_s == pytest.approx(samples.t_s, abs=1e-9)
    assert np.abs(motion.q_m - samples.q_m).max() <= 0.51e-12
    derivatives = ((motion.qd_mps, samples.qd_mps), (motion.qdd_mps2, samples.qdd_mps2))
    for found, written in derivatives if kind is not Format.CAM else ():  # a cam leaves rows out
        assert found is None or np.abs(found - written).max() <= 0.51e-12
    assert (motion.qd_mps is None) == (kind is Format.LINUXCNC)
    assert (motion.qdd_mps2 is None) == (kind in (Format.LINUXCNC, Format.PVT, Format.MJCF))


@pytest.mark.parametrize("period_s", PERIODS)
@pytest.mark.parametrize("kind", MOTIONS)
def test_positions_differenced_twice_are_accelerations(written_and_read, kind: Format, period_s: float) -> None:
    """Rounding in the file makes no more than a ten thousandth of the smallest limit, at any period."""
    samples, motion = written_and_read(kind, period_s)
    exact, found = (np.diff(q, 2, axis=0) / period_s**2 for q in (samples.q_m, motion.q_m))
    assert np.abs(found - exact).max(initial=0.0) <= 1.01e-4 * 0.5


def test_names_of_formats_are_known_without_numpy() -> None:
    """The command line reads them whenever it starts."""
    script = "import sys; from pipeline.export.formats import Format; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
    assert " ".join(Format) == "csv pvt cam ros2 ros2-json mcap linuxcnc beckhoff mjcf urdf"
    assert Format("ros2-json") is Format.ROS2_JSON


@pytest.mark.parametrize("period_s", PERIODS)
def test_needed_decimals_are_just_enough(period_s: float) -> None:
    """With one decimal less the worst rounding would show; in millimetres three fewer are needed."""
    needed = needed_decimals(period_s, LIMITS)
    worst = 4.0 * 0.5 * 10.0**-needed / period_s**2
    assert worst <= 1e-4 * 0.5 < 10.0 * worst
    assert needed_decimals(period_s, LIMITS, 0.001) == needed - 3


def test_a_joint_trajectory_is_one(make_samples) -> None:
    """Fields of the message, names of the configuration, strictly increasing times, no final velocity."""
    names = ("slide/a", "slide/b", "c", "d.x", "e")
    samples = make_samples(0.000125)
    text = format_samples(Format.ROS2, samples, LIMITS, names)
    message = yaml.safe_load(format_samples(Format.ROS2, make_samples(0.01), LIMITS, names))
    assert set(message) == {"header", "joint_names", "points"}
    assert message["joint_names"] == list(names)
    assert set(message["points"][0]) == {"positions", "velocities", "accelerations", "time_from_start"}
    assert all(isinstance(value, float) for point in message["points"] for value in point["velocities"])
    assert message["points"][-1]["velocities"] == [0.0] * 5
    stamps = [(int(a), int(b)) for a, b in re.findall(r"sec: (\d+), nanosec: (\d+)", text.split("points:")[1])]
    assert len(stamps) == len(samples)
    assert stamps == sorted(set(stamps))
    assert all(0 <= nanosec < 10**9 for _, nanosec in stamps)
    assert json.loads(format_samples(Format.ROS2_JSON, make_samples(0.01), LIMITS, names)) == message
    assert read_joint_trajectory(text).joint_names == names


def test_a_joint_trajectory_has_to_end_at_rest_and_time_to_pass(make_samples) -> None:
    """What a controller would refuse is not written."""
    samples = make_samples(0.01)
    moving = replace(samples, qd_mps=np.ones_like(samples.qd_mps))
    with pytest.raises(ValueError, match="end at rest"):
        format_yaml(ExportRequest(moving, LIMITS, ACTUATORS))
    frozen = replace(samples, t_s=samples.t_s * 1e-9)
    with pytest.raises(ValueError, match="increase strictly"):
        format_yaml(ExportRequest(frozen, LIMITS, ACTUATORS))


def test_halstreamer_lines_are_five_floats(make_samples) -> None:
    """Comments begin with #; all other lines have five numbers that strtod reads, and there is one per row."""
    text = format_halstreamer(ExportRequest(make_samples(0.001), LIMITS, ACTUATORS))
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert len(lines) == 201
    assert all(re.fullmatch(r"(-?\d+\.\d{12} ){4}-?\d+\.\d{12}", line) for line in lines)


@pytest.mark.parametrize(
    ("reader", "text", "message"),
    [
        (read_joint_trajectory, "points: 3", "not a joint trajectory"),
        (read_joint_trajectory, '{"points": [', "not a joint trajectory"),
        (read_joint_trajectory, "a: [", "not a joint trajectory"),
        (read_halstreamer, "# period_s: 0.01\n1 2 3\n", "line 2 has 3 values"),
        (read_halstreamer, "1 2 3 4 5\n", "no comment states the period"),
        (read_beckhoff, "Time_ms;a.Pos_mm\r\n0;1\r\n", "not those of this dialect"),
        (read_beckhoff, "Time_ms;a.Pos_mm;a.Vel_mmps\n", "not those of this dialect"),
        (read_mjcf, "<mujoco>", "not an MJCF file"),
        (read_mjcf, "<mujoco/>", "no keys"),
        (read_mjcf, '<mujoco><keyframe><key qpos="1"/></keyframe></mujoco>', "no joint of any drive"),
        (read_pvt, "t_s,c1_m\n0,1\n", "not a table of times, positions and velocities"),
        (read_cam, "VAR_GLOBAL", "not a declaration of cams"),
        (read_trajectory_csv, "t_s,q1_m\n0,1\n", "no column q2_m"),
    ],
)
def test_what_is_not_the_format_is_refused(reader, text: str, message: str) -> None:
    """A file of another kind, or one cut short, is named as such."""
    with pytest.raises(ValueError, match=message):
        reader(text)


@pytest.mark.parametrize("acceleration_mps2", [2.0, 1e-3, 1e-4])
def test_decimals_are_as_many_as_the_period_needs(acceleration_mps2: float) -> None:
    """Rounding makes no more than a ten thousandth of the limit, and with one decimal less it makes more."""
    decimals = needed_decimals(0.000_125, np.array([acceleration_mps2]))
    made = 2.0 * 10.0**-decimals / 0.000_125**2
    assert made <= 1e-4 * acceleration_mps2 < 10.0 * made


def test_no_more_decimals_than_numbers_have() -> None:
    """However small the limit."""
    assert needed_decimals(0.000_125, np.array([1e-9])) == 17


def test_csv_options(make_samples) -> None:
    """Separator, columns in the order asked for, units in the names, decimals as many as wanted."""
    samples = make_samples(0.01)
    options = ExportOptions(
        Separator.SEMICOLON,
        14,
        ("t_s", "q2_m", "qd1_mps", "qdd1_mps2", "ry_rad", "kappa"),
        LengthUnit.MM,
        AngleUnit.DEG,
    )
    text = format_samples(Format.CSV, samples, LIMITS, ACTUATORS, options)
    columns = read_csv(text, ";")
    assert list(columns) == ["t_s", "q2_mm", "qd1_mmps", "qdd1_mmps2", "ry_deg", "kappa"]
    assert columns["q2_mm"] == pytest.approx(1_000.0 * samples.q_m[:, 1], abs=1e-11)
    assert columns["qdd1_mmps2"] == pytest.approx(1_000.0 * samples.qdd_mps2[:, 0], abs=1e-11)
    assert columns["ry_deg"] == pytest.approx(np.rad2deg(samples.pose[:, 4]), abs=1e-11)
    assert columns["t_s"] == pytest.approx(samples.t_s, abs=1e-13)
    assert re.match(r"0\.\d{14};", text.splitlines()[1])
    assert "\t" in format_samples(Format.CSV, samples, LIMITS, ACTUATORS, ExportOptions(Separator.TAB))


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        (Format.CSV, ExportOptions(columns=("q9_m",)), "no column q9_m; choose from t_s"),
        (Format.CSV, ExportOptions(columns=("t_s", "t_s")), "twice"),
        (Format.CSV, ExportOptions(columns=()), "names no column; choose from t_s"),
        (Format.CSV, ExportOptions(decimals=6), "6 decimals are too few.*\n.*at least 11"),
        (Format.CSV, ExportOptions(decimals=7, length=LengthUnit.MM), "at least 8"),
        (Format.ROS2, ExportOptions(decimals=14), "--decimals goes with --format csv only, not with ros2"),
        (Format.PVT, ExportOptions(decimals=14), "--decimals goes with --format csv only"),
        (Format.CSV, ExportOptions(times=Times.RELATIVE), "--times goes with --format pvt only"),
        (Format.CSV, ExportOptions(lead_in_s=1.0), "--lead-in goes with --format ros2, ros2-json, mcap only"),
        (Format.BECKHOFF, ExportOptions(length=LengthUnit.MM), "--length goes with --format csv, pvt, cam, linuxcnc"),
        (Format.CSV, ExportOptions(decimal=DecimalMark.COMMA), "commas cannot separate values, too"),
        (Format.CSV, ExportOptions(columns=("qddd1_mps3",)), "no qddd1_mps3: accelerations of this motion jump"),
        (Format.CSV, ExportOptions(names=("a", "b")), "2 names for 23 columns"),
        (Format.CSV, ExportOptions(columns=("t_s", "q1_m"), names=("a", "a")), "name every column once"),
        (Format.ROS2, ExportOptions(lead_in_s=-1.0), "--lead-in is -1; allowed are 0 to 3600"),
        (Format.CAM, ExportOptions(tolerance_m=-1e-6), "--tolerance is -1e-06"),
        (Format.MJCF, ExportOptions(), "give ExportRequest its `machine`"),
    ],
)
def test_options_that_cannot_be_kept_are_refused(
    make_samples, kind: Format, options: ExportOptions, message: str
) -> None:
    """Fewer decimals than the period needs, unknown columns, options of another format."""
    with pytest.raises(UsageError, match=message):
        format_samples(kind, make_samples(0.001), LIMITS, ACTUATORS, options)


def test_what_is_no_text_or_no_motion_is_told(make_samples, machine: Machine) -> None:
    """A bag is written by `export_files`, and a URDF file holds no motion to read."""
    pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed")
    with pytest.raises(UsageError, match="use export_files"):
        format_samples(Format.MCAP, make_samples(0.01), LIMITS, ACTUATORS, machine=machine)
    with pytest.raises(UsageError, match="holds no motion"):
        read_motion(Format.URDF, "<robot/>")
