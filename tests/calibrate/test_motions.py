"""Calibration from motions: clock offsets are fitted, and told where they are left out."""

import re

import numpy as np
import pytest

from pipeline.calibrate import Calibration, DrivenMotion, Setting, StaticPoses, StaticSetting, calibrate, judge
from pipeline.calibrate import simulate_motion as simulate
from pipeline.calibrate.data.poses import Timing
from pipeline.calibrate.data.seen import close_at, seen_jacobian
from pipeline.calibrate.data.simulated import SimulatedPoses, simulate_static
from pipeline.calibrate.model.forward import positions
from pipeline.calibrate.model.parameters import CLOCK, CLOCKS, USUAL
from pipeline.calibrate.report import calibration_data, motion_words
from pipeline.config import Config
from pipeline.figures.calibration import calibration_figure
from tests.calibrate.conftest import REFLECTORS_M

PLACES = REFLECTORS_M[:2]
_WITHOUT = tuple(key for key in USUAL if key != CLOCKS.key)


@pytest.fixture(scope="module")
def late(quick_config: Config, driven: DrivenMotion) -> SimulatedPoses:
    """Measure a motion with a clock that is 40.1 ms late."""
    return simulate(quick_config, PLACES, driven, StaticSetting(poses=5), 0.0401)


@pytest.fixture(scope="module")
def checked(quick_config: Config, late: SimulatedPoses) -> Calibration:
    """Calibrate from the motion, a fifth of it held out."""
    return calibrate(quick_config, PLACES, late.poses, Setting(hold_out=0.2))


def joined(still: StaticPoses, moving: StaticPoses) -> StaticPoses:
    """Put static poses and a motion into one table."""
    assert moving.timing is not None
    count = len(still)
    timing = Timing(
        moving.timing.driven,
        np.append(np.full(count, -1), moving.timing.motion),
        np.append(np.full(count, np.nan), moving.timing.t_s),
    )
    q, seen = np.vstack([still.q_m, moving.q_m]), np.concatenate([still.seen_m, moving.seen_m])
    return StaticPoses(q, seen, timing=timing)


def test_derivatives_by_the_clock_are_those_of_differences(late: SimulatedPoses) -> None:
    """What is seen changes with the clock offset as finite differences say."""
    truth, poses, h = late.truth, late.poses, 1e-6
    closed = close_at(truth, poses, late.configured_pose)
    J = truth.parameters.of(CLOCKS, seen_jacobian(truth, poses, closed))[..., 0]
    after, before = (
        positions(model, close_at(model, poses, late.configured_pose))
        for model in (truth.with_clocks(truth.clocks_s + h), truth.with_clocks(truth.clocks_s - h))
    )
    assert pytest.approx((after - before) / (2.0 * h), abs=1e-6) == J
    assert np.abs(J).max() > 0.1


def test_without_noise_the_clock_is_exact(quick_config: Config, driven: DrivenMotion) -> None:
    """A machine as configured, seen without noise, is found as configured, with its clock offset."""
    setting = StaticSetting(poses=5, geometry_std_m=0.0, scale_std=0.0, noise_m=0.0)
    simulated = simulate(quick_config, PLACES, driven, setting, -0.0123)
    found = calibrate(quick_config, PLACES, simulated.poses, Setting()).identification
    assert found.model.clocks_s == pytest.approx([-0.0123], abs=1e-9)
    assert found.model.reflectors_m == pytest.approx(PLACES, abs=1e-9)
    assert found.model.platform_points_m == pytest.approx(simulated.truth.platform_points_m, abs=1e-9)
    assert found.residual_m == pytest.approx(0.0, abs=1e-9)


def test_the_clock_is_found_within_its_deviation(checked: Calibration) -> None:
    """It is told with a deviation that is honest; along the motion the machine is known, and elsewhere hardly."""
    calibration, found = checked, checked.identification
    deviation = found.model.parameters.of(CLOCKS, found.std)[0]
    assert 1e-6 < deviation < 1e-4
    assert abs(found.model.clocks_s[0] - 0.0401) < 4.0 * deviation
    assert found.evaluations <= 8
    verdict = judge(calibration)
    assert verdict.accepted
    assert calibration.reach is not None
    assert calibration.reach.elsewhere_m > 10.0 * calibration.reach.along_m
    assert "no calibration of the machine" in motion_words(calibration)[-1]
    data = calibration_data(calibration, verdict)
    assert data["clocks"] == [{"late_s": found.model.clocks_s[0], "std_s": deviation}]
    assert calibration.held_out is not None
    assert calibration.held_out.after_m == pytest.approx(calibration.held_out.predicted_m, rel=0.15)


def test_figures_are_drawn_of_motions(checked: Calibration) -> None:
    """Clocks have no row among the parameters of the machine: nothing is known of them beforehand."""
    for name in ("residuals", "parameters", "singular_values"):
        figure = calibration_figure(name, checked, judge(checked))
        figure.canvas.draw()
        labels = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
        assert not any(CLOCK in label for label in labels)


def test_static_poses_beside_a_motion_are_good_elsewhere(
    quick_config: Config, driven: DrivenMotion, late: SimulatedPoses
) -> None:
    """Of both together errors elsewhere are a fraction of those of the motion alone."""
    setting = StaticSetting(poses=40)
    still = simulate_static(quick_config, PLACES, setting)
    moving = simulate(quick_config, PLACES, driven, setting, 0.0401)
    both = calibrate(quick_config, PLACES, joined(still.poses, moving.poses), Setting())
    alone = calibrate(quick_config, PLACES, late.poses, Setting())
    assert both.reach is not None
    assert alone.reach is not None
    assert both.reach.elsewhere_m < 0.3 * alone.reach.elsewhere_m
    found = both.identification
    deviation = found.model.parameters.of(CLOCKS, found.std)[0]
    assert abs(found.model.clocks_s[0] - 0.0401) < 4.0 * deviation


def test_a_clock_that_is_not_fitted_is_told(quick_config: Config, driven: DrivenMotion) -> None:
    """Some milliseconds do not pass for another machine: the offset is said, and how to fit it."""
    poses = simulate(quick_config, PLACES, driven, StaticSetting(poses=5, geometry_std_m=5e-5), 0.005).poses
    verdict = judge(calibrate(quick_config, PLACES, poses, Setting(fit=_WITHOUT)))
    assert not verdict.accepted
    reason = verdict.reasons[-1]
    late_ms = float(re.search(r"the tracker's is late by \+([0-9.]+) ms", reason)[1])  # type: ignore[index]
    assert late_ms == pytest.approx(5.0, abs=0.1)
    assert "add clocks to --fit" in reason


def test_a_clock_that_is_far_off_is_told_before_outliers_are_sought(
    quick_config: Config, driven: DrivenMotion, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Robust fits of a motion that is 50 ms late hardly converge, and took minutes."""
    poses = simulate(quick_config, PLACES, driven, StaticSetting(poses=5), 0.05).poses
    calibration = calibrate(quick_config, PLACES, poses, Setting(fit=_WITHOUT))
    monkeypatch.setattr("pipeline.calibrate.verdict.identify_robustly", lambda _: pytest.fail("outliers are sought"))
    assert "the tracker's is late by +" in judge(calibration).reasons[-1]


def test_outliers_of_a_motion_are_left_out(quick_config: Config, driven: DrivenMotion) -> None:
    """A robust fit finds the clock all the same."""
    simulated = simulate(quick_config, PLACES, driven, StaticSetting(poses=5, outliers=0.02), 0.0401)
    found = calibrate(quick_config, PLACES, simulated.poses, Setting(robust=True))
    assert (found.rejected == simulated.is_outlier).all()
    assert found.identification.model.clocks_s == pytest.approx([0.0401], abs=2e-4)
