"""The stage: a path becomes a trajectory within all limits, or is refused with the reason."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError, UnfitConfigError
from pipeline.progress import Monitor
from pipeline.refine.result import Path
from pipeline.retime import TimingOptions, Trajectory, measure_usage, retime_path, sample_trajectory
from pipeline.retime.fastest import plan
from pipeline.retime.jerk.options import JerkOptions
from pipeline.retime.path_dynamics import evaluate_dynamics


def _config(config: Config, **options: Any) -> Config:
    return config.model_copy(update={"retime": RetimeConfig(**options)})


@pytest.fixture(scope="module")
def without_jerk(agder_config: Config) -> Config:
    """Take jerk as it comes."""
    return _config(agder_config, jerk=False)


@pytest.fixture(scope="module")
def plain(without_jerk: Config, path: Path) -> Trajectory:
    """Time the curve with them."""
    return retime_path(without_jerk, path)


@pytest.fixture(scope="module")
def limited(agder_config: Config, path: Path) -> Trajectory:
    """Time the curve as the reference machine does, with limited jerk."""
    return retime_path(agder_config, path)


def test_all_limits_hold_everywhere_and_the_period_fits(without_jerk: Config, path: Path, plain: Trajectory) -> None:
    """No limit is exceeded at all, the duration is a whole number of periods and at most two above the plan."""
    trajectory = plain
    period = without_jerk.retime.period_s
    assert measure_usage(trajectory, period).largest <= 1.0
    assert trajectory.duration_s == round(trajectory.duration_s / period) * period
    assert 0.0 <= trajectory.duration_s - plan(path, without_jerk.retime.grid_points).duration_s < 2.0 * period


def test_the_grid_is_refined_until_limits_hold_between_its_points(agder_config: Config, path: Path) -> None:
    """A grid that is too coarse is doubled, and every attempt is reported."""
    reported: list[str] = []
    monitor = Monitor(lambda message, fraction=None: reported.append(message))
    trajectory = retime_path(_config(agder_config, grid_points=60, jerk=False), path, monitor)
    assert len(reported) > 1
    assert "60 grid points" in reported[0]
    assert "120 grid points" in reported[1]
    assert measure_usage(trajectory).largest <= 1.0
    assert measure_usage(plan(path, 60)).largest > 1.001


def test_limits_that_stay_broken_on_the_finest_grid_cost_time(without_jerk: Config, path: Path) -> None:
    """When no finer grid is allowed, the motion is slowed down until all limits hold; the gap tells what it costs."""
    options, coarse = TimingOptions(most_grid_points=100), _config(without_jerk, grid_points=60, jerk=False)
    assert measure_usage(plan(path, 60)).largest > 1.001
    trajectory = retime_path(coarse, path, options=options)
    assert measure_usage(trajectory).largest <= 1.0
    assert trajectory.timing.gap > 0.01


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


def test_a_threefold_knot_is_fine_and_a_fourfold_one_is_not(
    without_jerk: Config, path: Path, plain: Trajectory
) -> None:
    """Degree minus multiplicity is the smoothness: two derivatives are needed."""

    def with_knot(times: int) -> Path:
        return replace(path, spline=path.spline.insert_knot(0.5, m=times))

    assert retime_path(without_jerk, with_knot(3)).duration_s == plain.duration_s
    with pytest.raises(NoSolutionError, match=r"s = 0\.5000"):
        retime_path(without_jerk, with_knot(4))


def test_jerk_is_limited_by_default_and_what_it_costs_is_reported(agder_config: Config, limited: Trajectory) -> None:
    """All limits hold at every tenth of a period; the gap without jerk is below half a percent."""
    trajectory = limited
    usage = measure_usage(trajectory, agder_config.retime.period_s)
    assert set(usage.held()) == {"velocity", "acceleration", "jerk", "force", "link_force"}
    assert usage.largest <= 1.001
    timing = trajectory.timing
    assert timing.jerk_limited
    assert 0.0 < timing.gap < 0.005
    assert 0.0 < timing.jerk_cost < 0.02
    assert timing.bound_s < timing.fastest_s < timing.motion_s <= trajectory.motion_s
    assert min(timing.pieces, timing.rounds, timing.iterations) > 0


def test_positions_at_a_millisecond_show_the_accelerations(path: Path, limited: Trajectory) -> None:
    """Second differences of the rows agree with qdd to a thousandth of the limit, everywhere."""
    samples = sample_trajectory(limited, 0.001)
    second = np.diff(samples.q_m, 2, axis=0) / 0.001**2
    assert (np.abs(second - samples.qdd_mps2[1:-1]) / path.machine.acceleration_mps2).max() < 1e-3


def test_without_jerk_limits_the_peak_tells_what_a_controller_sees(plain: Trajectory) -> None:
    """Accelerations jump: over a period that is many times the limit, the more the shorter the period."""
    trajectory = plain
    assert not trajectory.timing.jerk_limited
    assert trajectory.timing.jerk_cost == 0.0
    coarse, fine = (measure_usage(trajectory, period) for period in (0.01, 0.001))
    assert not fine.jerk_held
    assert fine.fractions["jerk"].max() > 5.0 * coarse.fractions["jerk"].max() > 5.0
    assert fine.largest <= 1.001
    assert "jerk" not in measure_usage(trajectory).fractions


@pytest.mark.parametrize(("speed", "dwell_s"), [(0.3, (0.0, 0.0)), (1.0, (0.503, 0.2)), (0.5, (0.01, 1.0))])
def test_speed_and_dwell(
    without_jerk: Config, path: Path, plain: Trajectory, speed: float, dwell_s: tuple[float, float]
) -> None:
    """The motion takes 1 / speed times as long, and nothing moves for whole periods before and after it."""
    config = _config(without_jerk, jerk=False, speed=speed, dwell_s=dwell_s)
    trajectory, full = retime_path(config, path), plain
    assert trajectory.motion_s == pytest.approx(full.timing.motion_s / speed, abs=0.0101)
    waits = np.ceil(np.array(dwell_s) / 0.01 - 1e-9) * 0.01
    assert trajectory.dwell_s == pytest.approx(waits)
    samples = sample_trajectory(trajectory, 0.01)
    assert samples.duration_s == pytest.approx(trajectory.motion_s + waits.sum())
    resting = (samples.t_s < waits[0] - 1e-9) | (samples.t_s > samples.duration_s - waits[1] - 1e-9)
    assert not samples.qd_mps[resting].any()
    assert not samples.qdd_mps2[resting].any()
    assert np.array_equal(samples.q_m[-1], path.q(1.0))
    usage, most = measure_usage(trajectory, 0.01), measure_usage(full, 0.01)
    assert usage.fractions["velocity"].max() == pytest.approx(speed * most.fractions["velocity"].max(), rel=5e-3)
    assert usage.fractions["acceleration"].max() == pytest.approx(
        speed**2 * most.fractions["acceleration"].max(), rel=1e-2
    )


def test_a_load_that_gravity_alone_exceeds_is_refused_with_the_pose(agder_config: Config, path: Path) -> None:
    """The limit, the force it takes, and where it is exceeded most; nothing is planned."""
    heavy = replace(path.machine, masses=replace(path.machine.masses, load_kg=300.0))
    with pytest.raises(
        NoSolutionError, match=r"needs .* N just to hold the machine at s = 0\..*, .* limit of .* at the pose x "
    ):
        retime_path(agder_config, replace(path, machine=heavy))


def test_a_locked_actuator_that_would_have_to_move_is_named(agder_config: Config, path: Path) -> None:
    """Velocity zero: which actuator, from where on."""
    velocity = path.machine.velocity_mps.copy()
    velocity[1] = 0.0
    locked = replace(path, machine=replace(path.machine, velocity_mps=velocity))
    with pytest.raises(
        NoSolutionError, match=r"c2 has to move from s = .* at the pose x .* its velocity limit is 0 m/s"
    ) as e:
        retime_path(agder_config, locked)
    assert e.value.exit_code == 1


def test_a_locked_actuator_that_need_not_move_is_fine(without_jerk: Config, line) -> None:
    """Carts move together along X: telescopes may be locked."""
    path = line(0.3)
    velocity = path.machine.velocity_mps.copy()
    velocity[3:] = 0.0
    locked = replace(path, machine=replace(path.machine, velocity_mps=velocity))
    assert retime_path(without_jerk, locked).duration_s == retime_path(without_jerk, path).duration_s


@pytest.mark.parametrize("jerk", [JerkOptions(rounds=1), JerkOptions(iterations=2)], ids=["one round", "not solved"])
def test_a_program_that_leaves_limits_exceeded_or_fails_costs_time(
    agder_config: Config, path: Path, jerk: JerkOptions
) -> None:
    """What rounds leave is removed by slowing down; without a solution the fastest law is smoothed, and slower."""
    trajectory = retime_path(_config(agder_config, jerk_pieces=40), path, options=TimingOptions(jerk=jerk))
    usage, law = measure_usage(trajectory, 0.01), trajectory.time_law
    assert usage.jerk_held
    assert usage.largest <= 1.001
    assert trajectory.timing.jerk_limited
    assert 0.0 < trajectory.timing.jerk_cost < 1.0
    assert all(abs(law(0.0, nu=order)) < 1e-9 for order in (1, 2, 3))


def test_fast_carts_are_no_reason_to_refuse_a_path(without_jerk: Config, path: Path, plain: Trajectory) -> None:
    """Whether a path nearly stops does not depend on limits; and a limit that no motion reaches changes nothing."""
    fast = path.machine.velocity_mps * np.array([40.0, 40.0, 40.0, 1.0, 1.0])
    faster = path.machine.velocity_mps * np.array([1e6, 1e6, 1e6, 1.0, 1.0])
    some, more = (
        retime_path(without_jerk, replace(path, machine=replace(path.machine, velocity_mps=v))) for v in (fast, faster)
    )
    assert more.timing.motion_s == pytest.approx(some.timing.motion_s, rel=1e-9)
    assert some.timing.motion_s < plain.timing.motion_s


def _barely_held(path: Path, factor: float) -> Path:
    """The curve with drives that are stronger than gravity by a factor."""
    static = np.abs(evaluate_dynamics(path, np.linspace(0.0, 1.0, 2_001)).c[:, :5]).max(axis=0)
    return replace(path, machine=replace(path.machine, force_n=factor * static))


@pytest.mark.parametrize(("factor", "jerk"), [(1.0005, False), (1.003, False), (1.0005, True)])
def test_drives_that_barely_hold_the_machine_move_it_slowly(
    agder_config: Config, path: Path, plain: Trajectory, limited: Trajectory, factor: float, jerk: bool
) -> None:
    """Half a permille more than gravity takes is enough: what is left for motion is used up, and no more."""
    weak = _barely_held(path, factor)
    trajectory = retime_path(_config(agder_config, jerk=jerk, jerk_pieces=100), weak)
    assert measure_usage(trajectory, 0.01).largest <= 1.001
    assert 0.0 <= trajectory.timing.gap < 0.02
    strong = limited if jerk else plain
    assert strong.duration_s < trajectory.duration_s < 1.5 * strong.duration_s


def test_a_motion_that_is_too_slow_by_itself_is_refused_as_well(agder_config: Config, path: Path) -> None:
    """A micrometre per second takes weeks."""
    crawling = replace(path, machine=replace(path.machine, tcp_speed_mps=1e-6, masses=None))
    with pytest.raises(UnfitConfigError, match="rows; allowed are 1,000,000"):
        retime_path(agder_config, crawling)


@pytest.mark.parametrize("tcp_speed_mps", [0.003, np.inf])
def test_the_gap_is_that_of_the_law_that_leaves_the_stage(
    without_jerk: Config, path: Path, tcp_speed_mps: float
) -> None:
    """Without jerk limits the motion is the fastest law itself, as it was stretched, and never below the bound."""
    trajectory = retime_path(without_jerk, replace(path, machine=replace(path.machine, tcp_speed_mps=tcp_speed_mps)))
    timing = trajectory.timing
    assert timing.fastest_s == timing.motion_s
    assert 0.0 <= trajectory.motion_s - timing.motion_s < 0.01
    assert 0.0 <= timing.gap < 0.005


def test_more_rows_than_a_table_may_have_are_refused_before_they_are_made(without_jerk: Config, path: Path) -> None:
    """So slow that every period would fill the memory: the keys to change are named."""
    config = _config(without_jerk, jerk=False, speed=0.000_02)
    with pytest.raises(UnfitConfigError, match=r"retime\.period_s is .* rows; allowed are 1,000,000") as e:
        retime_path(config, path)
    assert e.value.exit_code == 2
    assert "retime.speed" in e.value.advice
