"""Limits and time have no scale of their own: random paths and limits, on other clocks and with more allowed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from pipeline.config import Config, RetimeConfig
from pipeline.machine import Machine
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_usage, retime_path, time_reversed
from pipeline.retime.fastest import plan

SEEDS = st.integers(0, 1_000_000)
CLOCKS = st.floats(-4.0, 4.0).map(lambda exponent: 10.0**exponent)
RAISES = st.one_of(st.floats(1.01, 1.5), st.floats(0.0, 6.0).map(lambda exponent: 10.0**exponent))
LIMITS = ("velocity_mps", "acceleration_mps2", "jerk_mps3")


def _random_path(machine: Machine, seed: int) -> Path:
    """A spline in actuator space that drifts and bends, under limits from a hundredth to a hundredfold."""
    rng = np.random.default_rng(seed)
    count = rng.integers(7, 16)
    knots = np.concatenate([np.zeros(5), np.linspace(0.0, 1.0, count - 4), np.ones(5)])
    bends = np.cumsum(rng.normal(size=(count, 5)), axis=0) * 10.0 ** rng.uniform(-2.0, -1.0, 5)
    drift = np.linspace(0.0, rng.uniform(1.0, 3.0), count)[:, None] * rng.choice([-1.0, 1.0], 5)
    random = {
        name: typical * 10.0 ** rng.uniform(-2.0, 2.0, 5)
        for name, typical in zip(LIMITS, (0.3, 2.0, 40.0), strict=True)
    }
    # Without masses and limits of the TCP no pose is needed.
    free = replace(machine, masses=None, **random)
    return Path(free, BSpline(knots, bends + drift, 5), np.array([0.0, 1.0]), np.zeros((2, 6)))


def _with(path: Path, **factors: float) -> Path:
    scaled = {name: getattr(path.machine, name) * factor for name, factor in factors.items()}
    return replace(path, machine=replace(path.machine, **scaled))


def _on_clock(path: Path, k: float) -> Path:
    """Velocities times k, accelerations times k^2, jerks times k^3."""
    return _with(path, velocity_mps=k, acceleration_mps2=k**2, jerk_mps3=k**3)


def _timed(config: Config, path: Path, jerk: bool, period_s: float) -> Trajectory:
    """Time with a period that no configuration has to allow."""
    options = RetimeConfig(jerk=jerk, jerk_pieces=40, grid_points=500, bound_points=200)
    changed = options.model_copy(update={"period_s": period_s})
    return retime_path(config.model_copy(update={"retime": changed}), path)


@settings(max_examples=100)
@given(seed=SEEDS, k=CLOCKS)
def test_a_plan_on_another_clock_is_the_same(machine: Machine, seed: int, k: float) -> None:
    """The duration is divided by k to 1e-9, over eight decades."""
    path = _random_path(machine, seed)
    assert plan(_on_clock(path, k), 200).duration_s * k == pytest.approx(plan(path, 200).duration_s, rel=1e-9)


@settings(max_examples=100)
@given(seed=SEEDS, factor=RAISES, name=st.sampled_from(LIMITS[:2]), actuator=st.integers(0, 4))
def test_a_plan_with_more_allowed_is_not_longer(
    machine: Machine, seed: int, factor: float, name: str, actuator: int
) -> None:
    """Raising one limit by anything."""
    path = _random_path(machine, seed)
    raised = np.ones(5)
    raised[actuator] = factor
    assert plan(_with(path, **{name: raised}), 500).duration_s <= plan(path, 500).duration_s * (1.0 + 1e-3)


@pytest.mark.parametrize(("jerk", "examples"), [(False, 8), (True, 4)], ids=["no jerk limits", "jerk limits"])
def test_the_stage_is_the_same_on_another_clock_and_not_slower_with_more_allowed(
    agder_config: Config, machine: Machine, jerk: bool, examples: int
) -> None:
    """Motion, bound and whole periods divide by k to 1e-6; a raised limit costs less than 0.1 %; all limits hold."""

    @settings(max_examples=examples)
    @given(seed=SEEDS, k=CLOCKS, factor=RAISES, name=st.sampled_from(LIMITS), actuator=st.integers(0, 4))
    def check(seed: int, k: float, factor: float, name: str, actuator: int) -> None:
        path = _random_path(machine, seed)
        period_s = plan(path, 200).duration_s / 400.0
        trajectory = _timed(agder_config, path, jerk, period_s)
        assert measure_usage(trajectory, period_s).largest <= 1.001
        assert measure_usage(time_reversed(trajectory), period_s).largest <= 1.001
        other = _timed(agder_config, _on_clock(path, k), jerk, period_s / k)
        assert other.duration_s * k == pytest.approx(trajectory.duration_s, rel=1e-6)
        assert other.timing.motion_s * k == pytest.approx(trajectory.timing.motion_s, rel=1e-6)
        assert other.timing.bound_s * k == pytest.approx(trajectory.timing.bound_s, rel=1e-6)
        raised = np.ones(5)
        raised[actuator] = factor
        more = _timed(agder_config, _with(path, **{name: raised}), jerk, period_s)
        assert more.timing.motion_s <= trajectory.timing.motion_s * (1.0 + 1e-3)

    check()


@pytest.mark.parametrize(
    "limits",
    [
        {"velocity_mps": np.array([0.002, 0.002, 0.002, 1.0, 1.0])},
        {"velocity_mps": np.array([40.0, 40.0, 40.0, 1.0, 1.0])},
        {"acceleration_mps2": 1e-3},
        {"acceleration_mps2": 1e3, "jerk_mps3": 1e6},
        {"jerk_mps3": 1e-4},
    ],
    ids=["slow carts", "fast carts", "small accelerations", "large accelerations and jerks", "small jerks"],
)
def test_limits_of_any_ratio_are_timed_with_few_iterations(agder_config: Config, path: Path, limits) -> None:
    """Very short ramps, or nothing but jerk: all limits hold, and few iterations do."""
    limited = _with(path, **limits)
    period_s = plan(limited, 200).duration_s / 400.0
    trajectory = _timed(agder_config, limited, True, period_s)
    assert measure_usage(trajectory, period_s).largest <= 1.001
    assert 0 < trajectory.timing.iterations < 600
    assert trajectory.timing.gap >= -1e-6
