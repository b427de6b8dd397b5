"""Exports say what a controller makes of their rows, and are slow enough for it on request."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from pipeline.cli.motions.rows import interpolated_by_controller
from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.export.formats import Format
from pipeline.machine import Machine, inverse_kinematics
from pipeline.refine.result import Path
from pipeline.retime import Trajectory
from pipeline.run.reading import with_retime
from tests.retime.proof.conftest import at_rest_at_both_ends, of_degree_two

_DURATION_S = 4.1


@pytest.fixture(scope="module")
def straight(machine: Machine) -> Trajectory:
    """Drive all carts a metre, at constant acceleration to the middle of a period, within limits it just keeps."""
    s = np.linspace(0.0, 1.0, 12)
    solution = inverse_kinematics(machine, np.array([[1.02, 0.30, 0.90, 0.0, 0.0]]), np.zeros(1, dtype=np.int64))
    q = solution.q_m + s[:, None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0])
    limited = replace(
        machine,
        velocity_mps=np.full(5, 1.0005 * 2.0 / _DURATION_S),
        acceleration_mps2=np.full(5, 1.0005 * 4.0 / _DURATION_S**2),
    )
    path = Path(limited, make_interp_spline(s, q, k=5), s, solution.pose + s[:, None] * np.eye(6)[0])
    return of_degree_two(at_rest_at_both_ends(path), _DURATION_S)


@pytest.fixture
def slow_controller(agder_config: Config) -> Config:
    """Sample ten times a second."""
    return with_retime(agder_config, period_s=0.1)


def test_rows_that_exceed_a_limit_are_warned_of(
    straight: Trajectory, slow_controller: Config, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the period, the interpolation and the limit, and advice that helps."""
    assert interpolated_by_controller(Format.CSV, straight, slow_controller, safe=False) is straight
    said = capsys.readouterr().err
    assert "Warning: rows 0.1 s apart, interpolated by cubic polynomials, take c" in said
    assert "--safe" in said
    safe = interpolated_by_controller(Format.CSV, straight, slow_controller, safe=True)
    assert f"{safe.motion_s:g} s instead of 4.1 s, +" in capsys.readouterr().err
    interpolated_by_controller(Format.CSV, safe, slow_controller, safe=False)
    assert capsys.readouterr().err == ""


def test_only_what_a_format_is_read_by_is_warned_of(
    straight: Trajectory, slow_controller: Config, capsys: pytest.CaptureFixture[str]
) -> None:
    """Cubics for PVT, quintics for ROS 2, lines for LinuxCNC, and so --safe of the last leaves the motion as it is."""
    for kind, named in ((Format.PVT, {"cubic"}), (Format.ROS2, {"quintic"}), (Format.LINUXCNC, set())):
        interpolated_by_controller(kind, straight, slow_controller, safe=False)
        said = capsys.readouterr().err
        assert {method for method in ("linear", "cubic", "quintic") if f"by {method} " in said} == named
    slower = interpolated_by_controller(Format.LINUXCNC, straight, slow_controller, safe=True)
    assert slower.motion_s == pytest.approx(straight.motion_s)


def test_formats_without_rows_have_nothing_to_keep(
    straight: Trajectory, slow_controller: Config, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither a warning nor a slower motion; the latter is refused with the reason."""
    for kind in (Format.URDF, Format.CAM):
        assert interpolated_by_controller(kind, straight, slow_controller, safe=False) is straight
        with pytest.raises(UsageError, match="leave --safe out"):
            interpolated_by_controller(kind, straight, slow_controller, safe=True)
    assert capsys.readouterr().err == ""
