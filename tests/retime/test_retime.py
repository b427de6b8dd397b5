"""The stage: a path becomes a trajectory within all limits, or is refused with the reason."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import measure_usage, retime_path
from pipeline.retime.plan import plan


def _config(config: Config, **options: Any) -> Config:
    return config.model_copy(update={"retime": RetimeConfig(**options)})


@pytest.fixture(scope="module")
def without_jerk(agder_config: Config) -> Config:
    """Take jerk as it comes."""
    return _config(agder_config, jerk=False)


def test_all_limits_hold_everywhere_and_the_period_fits(without_jerk: Config, path: Path) -> None:
    """No limit is exceeded at all, the duration is a whole number of periods and at most two above the plan."""
    trajectory = retime_path(without_jerk, path)
    period = without_jerk.retime.period_s
    assert measure_usage(trajectory, period).largest <= 1.0
    assert trajectory.duration_s == round(trajectory.duration_s / period) * period
    assert 0.0 <= trajectory.duration_s - plan(path, without_jerk.retime.grid_points).duration_s < 2.0 * period


def test_the_grid_is_refined_until_limits_hold_between_its_points(agder_config: Config, path: Path) -> None:
    """A grid that is too coarse is doubled, and every attempt is told."""
    told: list[str] = []
    trajectory = retime_path(
        _config(agder_config, grid_points=60, jerk=False), path, lambda message, fraction=None: told.append(message)
    )
    assert len(told) > 1
    assert "60 grid points" in told[0]
    assert "120 grid points" in told[1]
    assert measure_usage(trajectory).largest <= 1.0
    assert measure_usage(plan(path, 60)).largest > 1.001


def test_limits_that_stay_broken_on_the_finest_grid_are_an_error(
    agder_config: Config, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When no finer grid is allowed, a broken limit is told and nothing comes out."""
    monkeypatch.setattr("pipeline.retime.retime._MOST_GRID_POINTS", 100)
    with pytest.raises(NoSolutionError, match=r"limit of .* between two grid points"):
        retime_path(_config(agder_config, grid_points=60), path)


def test_a_path_that_does_not_move_is_refused(agder_config: Config, path: Path) -> None:
    """Start and goal alike, with nothing between."""
    still = replace(path, spline=BSpline(path.spline.t, np.repeat(path.spline.c[:1], len(path.spline.c), axis=0), 5))
    with pytest.raises(NoSolutionError, match="does not move"):
        retime_path(agder_config, still)


@pytest.mark.parametrize("slowdown", [1.0, 0.99, 0.96])
def test_a_path_that_nearly_stops_is_refused_with_the_place(agder_config: Config, line, slowdown: float) -> None:
    """Where |q'(s)| falls far below its mean, timing would be wrong without a word: so it is not tried."""
    slow = line(0.9, lambda s: s - slowdown * np.sin(2.0 * np.pi * (s - 0.37)) / (2.0 * np.pi), 200)
    with pytest.raises(NoSolutionError, match=r"nearly stops at s = 0\.3[67]") as caught:
        retime_path(agder_config, slow)
    assert caught.value.diagnosis["s"] == pytest.approx(0.37, abs=1e-3)
    assert caught.value.diagnosis["relative_speed"] == pytest.approx(1.0 - slowdown, abs=1e-3)


@pytest.mark.parametrize("slowdown", [0.5, 0.9])
def test_a_path_that_only_slows_down_is_timed_rightly(without_jerk: Config, line, slowdown: float) -> None:
    """Down to a tenth of the mean speed, a line takes the time a line has to take, and keeps all limits."""
    slow = line(0.9, lambda s: s - slowdown * np.sin(2.0 * np.pi * (s - 0.37)) / (2.0 * np.pi), 200)
    trajectory = retime_path(without_jerk, slow)
    assert trajectory.duration_s == pytest.approx(2.05, abs=0.0201)
    assert measure_usage(trajectory).largest <= 1.0


@pytest.mark.parametrize("degree", [1, 2])
def test_a_path_with_corners_is_refused(agder_config: Config, path: Path, degree: int) -> None:
    """Straight lines joined at corners, and arcs joined without curvature, cannot be driven without stopping."""
    s = np.linspace(0.0, 1.0, 8)
    rough = replace(path, spline=make_interp_spline(s, path.q(s), k=degree))
    with pytest.raises(NoSolutionError, match="jumps at s = "):
        retime_path(agder_config, rough)


def test_a_threefold_knot_is_fine_and_a_fourfold_one_is_not(without_jerk: Config, path: Path) -> None:
    """Degree less multiplicity tells the smoothness: two derivatives are needed."""

    def with_knot(times: int) -> Path:
        return replace(path, spline=path.spline.insert_knot(0.5, m=times))

    assert retime_path(without_jerk, with_knot(3)).duration_s == retime_path(without_jerk, path).duration_s
    with pytest.raises(NoSolutionError, match=r"s = 0\.5000"):
        retime_path(without_jerk, with_knot(4))
