"""Trip limits for controllers: never more than is proven, in the places where controllers look for them."""

import configparser

import numpy as np
import pytest
import yaml

from pipeline.certify.recheck.tube import ProvenTube
from pipeline.export import ExportOptions, ExportRequest, export_files
from pipeline.export.controllers.trip_limits import format_linuxcnc_ini, format_ros2_constraints, trip_limits
from pipeline.export.formats import TRIP_INI, TRIP_YAML, Format, LengthUnit
from pipeline.machine.actuator_space.controller_units import ControllerUnits
from pipeline.machine.geometry import ACTUATORS

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])
NAMES = ("slide/a", "slide: b", "c", "d.x", "e")
TUBE = ProvenTube(np.full(5, 2.75e-3), within_limits=False)
OFF = np.array([1e-5, 2e-5, 0.0, 1.23456e-5, 0.0])


def _request(samples, **changes) -> ExportRequest:
    names = changes.pop("joint_names", NAMES)
    return ExportRequest(samples, LIMITS, names, **{"tube": TUBE, "deviation_m": OFF, **changes})


def test_parameters_of_joint_trajectory_controller(make_samples) -> None:
    """Every joint by its name, on the way and at the goal, with what is between the points taken away."""
    text = format_ros2_constraints(_request(make_samples(0.01)))
    constraints = yaml.safe_load(text)["joint_trajectory_controller"]["ros__parameters"]["constraints"]
    assert constraints.pop("stopped_velocity_tolerance") > 0.0
    assert constraints.pop("goal_time") > 0.0
    assert tuple(constraints) == NAMES
    for joint, proven in zip(constraints.values(), TUBE.errors_m - OFF, strict=True):
        assert set(joint) == {"trajectory", "goal"}
        for limit in joint.values():
            assert isinstance(limit, float)
            assert proven - 1e-7 <= limit <= proven
    assert "limits may be broken" in text


@pytest.mark.parametrize(
    ("off_m", "told"), [(0.0, None), (4.8e-9, "4.8 nm"), (2.5e-6, "2.5 um"), (3.1e-4, "0.31 mm"), (1e-3, "1 mm")]
)
def test_what_is_taken_away_is_told_in_a_fitting_unit(make_samples, off_m: float, told: str | None) -> None:
    """And not at all where it is nothing; a joint with the actuator's name has it once."""
    request = _request(make_samples(0.01), deviation_m=np.full(5, off_m), joint_names=ACTUATORS)
    for text in (format_ros2_constraints(request), format_linuxcnc_ini(request)):
        assert ("Taken away" in text) is (told is not None)
        assert told is None or f"Taken away: {told}, " in text
    assert "\n# c1\n" in format_linuxcnc_ini(request)


@pytest.mark.parametrize("unit", [*LengthUnit])
def test_sections_of_linuxcnc(make_samples, unit: LengthUnit) -> None:
    """The same limit at any velocity, in the unit of the positions, a joint per section."""
    options = ExportOptions(length=unit)
    text = format_linuxcnc_ini(_request(make_samples(0.01), deviation_m=None, options=options))
    ini = configparser.ConfigParser()
    ini.optionxform = str
    ini.read_string(text)
    assert ini.sections() == [f"JOINT_{k}" for k in range(5)]
    for section in ini.sections():
        assert set(ini[section]) == {"FERROR", "MIN_FERROR"}
        assert ini[section]["FERROR"] == ini[section]["MIN_FERROR"]
        assert float(ini[section]["FERROR"]) * unit.metres == pytest.approx(2.75e-3, abs=1.1e-7)
        assert float(ini[section]["FERROR"]) * unit.metres <= 2.75e-3 * (1.0 + 1e-12)


@pytest.mark.parametrize("changes", [{"tube": None}, {"deviation_m": np.array([0.0, 0.0, 0.0, 0.0, 2.75e-3])}])
def test_without_anything_proven_nothing_is_written(make_samples, changes: dict) -> None:
    """A tolerance of 0 would switch the check off."""
    request = _request(make_samples(0.01), **changes)
    assert trip_limits(request) is None
    assert set(export_files(Format.ROS2, request)) == {""}
    assert set(export_files(Format.LINUXCNC, request)) == {"", ".hal"}


def test_they_are_beside_the_motion(make_samples) -> None:
    """With formats for controllers that have such limits."""
    request = _request(make_samples(0.01))
    assert TRIP_YAML in export_files(Format.ROS2, request)
    assert TRIP_YAML in export_files(Format.ROS2_JSON, request)
    assert TRIP_INI in export_files(Format.LINUXCNC, request)


def test_what_is_called_proven_holds_for_every_actuator_in_units_of_the_controller(make_samples) -> None:
    """Scales make the proven errors differ: the comment has the least of them, each limit its own."""
    units = ControllerUnits(np.zeros(5), np.zeros(5), np.array([0.9, 1.0, 1.0, 1.1, 1.0]))
    text = export_files(Format.ROS2, _request(make_samples(0.01), deviation_m=None, units=units))[TRIP_YAML].decode()
    constraints = yaml.safe_load(text)["joint_trajectory_controller"]["ros__parameters"]["constraints"]
    limits = np.array([constraints[name]["trajectory"] for name in NAMES])
    assert "with every actuator up to 2.5 mm off" in text
    np.testing.assert_allclose(limits, TUBE.errors_m / units.scales, atol=1.1e-7)
    assert (limits <= TUBE.errors_m / units.scales).all()
