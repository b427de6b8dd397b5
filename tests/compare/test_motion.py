"""How paths move once they are timed alike."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import PPoly, make_interp_spline

from pipeline.compare.blend import blended
from pipeline.compare.motion import MotionFigures, at_duration, common_retiming, measure_motion, retimed
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.result import Path
from pipeline.retime.result import Trajectory, stretched
from tests.compare.test_blend import zigzag


@pytest.fixture(scope="module")
def line(machine: Machine) -> Path:
    """Give a path along which every actuator moves evenly: carts by 0.1 m, telescopes by 0.02 m."""
    s = np.linspace(0.0, 1.0, 7)
    start = zigzag(machine).spline.c[0]
    q = start + s[:, None] * np.array([0.1, 0.1, -0.1, 0.02, 0.02])
    return Path(machine, make_interp_spline(s, q, k=5), s, np.tile(zigzag(machine).node_pose[0], (7, 1)))


@pytest.fixture(scope="module")
def smoothstep(line: Path) -> Trajectory:
    """Drive it in two seconds with s = 10 u^3 - 15 u^4 + 6 u^5, whose derivatives are known."""
    powers = 2.0 ** np.array([5, 4, 3, 2, 1, 0])
    return Trajectory(line, PPoly(np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])[:, None] / powers[:, None], [0.0, 2.0]))


def test_peaks_are_those_of_the_law(smoothstep: Trajectory) -> None:
    """Peak acceleration is 10 / sqrt(3) / T^2, peak jerk 60 / T^3, times the travel of carts and telescopes."""
    figures = measure_motion(smoothstep)
    acceleration, jerk = 10.0 / np.sqrt(3.0) / 4.0, 60.0 / 8.0
    assert figures.duration_s == 2.0
    assert figures.cart_acceleration_mps2 == pytest.approx(0.1 * acceleration, rel=1e-5)
    assert figures.telescope_acceleration_mps2 == pytest.approx(0.02 * acceleration, rel=1e-5)
    assert figures.cart_jerk_mps3 == pytest.approx(0.1 * jerk)
    assert figures.telescope_jerk_mps3 == pytest.approx(0.02 * jerk)


def test_another_duration_is_that_of_the_stretched_motion(smoothstep: Trajectory) -> None:
    """Scaled figures are those of the motion itself, stretched; its quality is left out."""
    scaled = dataclasses.asdict(at_duration(measure_motion(smoothstep), 5.0))
    planned = dataclasses.replace(measure_motion(stretched(smoothstep, 5.0)), quality=None)
    assert scaled == pytest.approx(dataclasses.asdict(planned))


def test_jumps_have_no_bounded_jerk(line: Path) -> None:
    """Where accelerations jump, jerk is infinite."""
    points = ([0.0, 1.0, 2.0], [0.0, 0.5, 1.0], [0.0, 1.0, 0.0], [1.0, -1.0, 0.0])
    figures = measure_motion(Trajectory.from_breakpoints(line, *(np.array(values) for values in points)))
    assert figures.quality is not None
    assert figures.quality.motion_s == 2.0
    figures = dataclasses.replace(figures, quality=None)
    assert figures == MotionFigures(2.0, pytest.approx(0.1), pytest.approx(0.02), np.inf, np.inf)


def test_retiming_is_the_same_for_all(agder_config: Config) -> None:
    """Speed and dwelling are left aside, everything else is the configuration's."""
    own = agder_config.retime.model_copy(update={"speed": 0.3, "dwell_s": (1.0, 2.0), "period_s": 0.002})
    common = common_retiming(agder_config.model_copy(update={"retime": own}))
    assert common == own.model_copy(update={"speed": 1.0, "dwell_s": (0.0, 0.0)})


def test_rounder_corners_are_driven_faster(agder_config: Config, machine: Machine) -> None:
    """The more a controller may cut corners, the shorter the motion; without a corner rounded it stops at each."""
    fast = common_retiming(agder_config).model_copy(update={"jerk": False, "grid_points": 500, "bound_points": 100})
    coarse = zigzag(machine)
    durations = [retimed(agder_config, fast, blended(coarse, tolerance)).motion_s for tolerance in (0.001, 0.004)]
    assert durations[1] < durations[0]


def test_pieces_that_are_too_coarse_are_halved(agder_config: Config, line: Path, smoothstep: Trajectory) -> None:
    """A failure with limited jerk is tried once more with twice the pieces; one without is raised."""
    asked: list[int] = []

    def retime_path(config: Config, path: Path) -> Trajectory:
        asked.append(config.retime.jerk_pieces)
        if not config.retime.jerk or config.retime.jerk_pieces < 600:
            raise NoSolutionError("retime", "too coarse", "more pieces")
        return smoothstep

    common = common_retiming(agder_config)
    assert retimed(agder_config, common, line, retime_path) is smoothstep
    assert asked == [300, 600]
    with pytest.raises(NoSolutionError, match="too coarse"):
        retimed(agder_config, common.model_copy(update={"jerk": False}), line, retime_path)
