"""The planner: known fastest times, an independent optimum, symmetries, convergence, honest failure."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.sparse import diags_array, vstack

from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.result import Path
from pipeline.retime import measure_usage
from pipeline.retime.fastest import plan
from pipeline.retime.path_dynamics import grid


def _with_limits(path: Path, velocity: float = 1.0, acceleration: float = 1.0, travel: float = 1.0) -> Path:
    """The path with scaled limits and scaled actuator coordinates."""
    machine = replace(
        path.machine,
        velocity_mps=path.machine.velocity_mps * velocity,
        acceleration_mps2=path.machine.acceleration_mps2 * acceleration,
        masses=None,
    )
    spline = path.spline.construct_fast(path.spline.t, path.spline.c * travel, path.spline.k)
    return replace(path, machine=machine, spline=spline)


@pytest.mark.parametrize("travel_m", [0.9, 0.3, 0.1, 0.01])
def test_a_straight_line_takes_its_trapezoid_or_bang_bang_time(line, machine: Machine, travel_m: float) -> None:
    """D / v + v / a when the top speed v is reached, else 2 sqrt(D / a)."""
    v, a = machine.velocity_mps[0], machine.acceleration_mps2[0]
    expected = travel_m / v + v / a if travel_m > v**2 / a else 2.0 * np.sqrt(travel_m / a)
    assert plan(line(travel_m), 1_000).duration_s == pytest.approx(expected, rel=5e-4)


def test_the_time_of_a_line_does_not_depend_on_how_s_runs_along_it(line) -> None:
    """A line with s bent to half and one and a half of its mean speed takes as long as the straight one."""
    bent = line(0.9, lambda s: s - 0.5 * np.sin(4.0 * np.pi * s) / (4.0 * np.pi), 60)
    assert plan(bent, 1_000).duration_s == pytest.approx(2.05, rel=5e-4)


def _optimum_by_linear_program(path: Path, points: int) -> float:
    """The same problem discretised and solved in another way.

    The fastest law has the largest sd^2 =: x everywhere, so the sum of x is maximised, with accelerations held
    at the middle of every interval and velocities at the points of an even grid.
    """
    s = np.linspace(0.0, 1.0, points)
    ds, middle = np.diff(s), (s[1:] + s[:-1]) / 2.0
    first, second = path.q(middle, 1).T, path.q(middle, 2).T
    rows = [
        diags_array([b / 2.0 - a / (2.0 * ds), b / 2.0 + a / (2.0 * ds)], offsets=[0, 1], shape=(points - 1, points))
        for a, b in zip(first, second, strict=True)
    ]
    limits = np.repeat(path.machine.acceleration_mps2, points - 1)
    largest = ((path.machine.velocity_mps / np.maximum(np.abs(path.q(s, 1)), 1e-9)) ** 2).min(axis=1)
    largest[[0, -1]] = 0.0
    matrix = vstack(rows, format="csr")
    found = linprog(
        -np.ones(points),
        A_ub=vstack([matrix, -matrix], format="csr"),
        b_ub=np.tile(limits, 2),
        bounds=np.stack([np.zeros(points), largest], axis=1),
    )
    sd = np.sqrt(found.x)
    return float((2.0 * ds / (sd[1:] + sd[:-1])).sum())


def test_it_agrees_with_an_optimum_found_by_linear_programming(path: Path) -> None:
    """Another discretisation and another algorithm give the same duration."""
    assert plan(path, 1_000).duration_s == pytest.approx(_optimum_by_linear_program(path, 601), rel=2e-3)


def test_the_way_back_takes_as_long(path: Path, reversed_path: Path) -> None:
    """Limits are symmetric, so the fastest law of the reversed path is the reversed law."""
    assert plan(reversed_path, 1_000).duration_s == pytest.approx(plan(path, 1_000).duration_s, rel=2e-4)


@settings(max_examples=25)
@given(exponent=st.floats(-4.0, 4.0))
def test_limits_of_k_and_k_squared_shorten_the_time_by_k(path: Path, exponent: float) -> None:
    """Velocities times k and accelerations times k^2 are the same motion seen on another clock, for any k."""
    k = 10.0**exponent
    fast = plan(_with_limits(path, velocity=k, acceleration=k**2), 200)
    assert fast.duration_s * k == pytest.approx(plan(path, 200).duration_s, rel=1e-8)


@settings(max_examples=25)
@given(exponent=st.floats(-4.0, 4.0))
def test_the_unit_of_length_does_not_matter(path: Path, exponent: float) -> None:
    """Scaling travel, velocities and accelerations alike leaves the time as it was."""
    k = 10.0**exponent
    scaled = plan(_with_limits(path, velocity=k, acceleration=k, travel=k), 200)
    assert scaled.duration_s == pytest.approx(plan(path, 200).duration_s, rel=1e-8)


@pytest.mark.parametrize(("velocity", "acceleration"), [(1e6, 1.0), (1.0, 1e-8), (1.0, 1e6)])
def test_either_limit_may_dominate_by_far(path: Path, velocity: float, acceleration: float) -> None:
    """With only one kind of limit that matters, the other is used little and the first wholly."""
    usage = measure_usage(plan(_with_limits(path, velocity, acceleration), 1_000))
    assert usage.largest == pytest.approx(1.0, abs=2e-3)
    assert min(usage.fractions["velocity"].max(), usage.fractions["acceleration"].max()) < (
        1.0 if velocity == acceleration else 0.2
    )


def test_finer_grids_converge(path: Path) -> None:
    """The duration converges with the first order, what is exceeded between the points with the second."""
    points = np.array([250, 500, 1_000, 2_000])
    plans = [plan(path, n) for n in points]
    duration_error = np.array([planned.duration_s for planned in plans]) - plan(path, 16_000).duration_s
    excess = np.array([measure_usage(planned).largest for planned in plans]) - 1.0

    def order(errors: np.ndarray) -> float:
        return -float(np.polyfit(np.log(points), np.log(np.abs(errors)), 1)[0])

    assert order(duration_error) > 0.8
    assert order(excess) > 1.7
    assert excess[-1] < 1e-4


def test_more_is_never_slower(path: Path) -> None:
    """Raising a limit cannot lengthen the motion."""
    durations = [plan(_with_limits(path, acceleration=factor), 500).duration_s for factor in (0.5, 1.0, 2.0, 4.0)]
    assert np.all(np.diff(durations) < 0.0)


def test_some_limit_is_always_used_up(path: Path) -> None:
    """A fastest law rides on a limit at every instant (bang-bang principle)."""
    planned = plan(path, 1_000)
    machine = path.machine
    t = (planned.time_law.x[1:] + planned.time_law.x[:-1])[5:-5] / 2.0
    velocity = np.abs(planned.q(t, 1) / machine.velocity_mps).max(axis=1)
    acceleration = np.abs(planned.q(t, 2) / machine.acceleration_mps2).max(axis=1)
    assert np.mean(np.maximum(velocity, acceleration) > 0.98) > 0.97


def test_the_grid_runs_from_zero_to_one_and_is_dense_at_the_ends() -> None:
    """The ends are exact, points strictly ascend even on the finest grid, and the first cell is the smallest."""
    s = grid(40_000)
    assert s[0] == 0.0
    assert s[-1] == 1.0
    cells = np.diff(s)
    assert np.all(cells > 0.0)
    assert cells[0] < 1e-3 * cells.max()


@pytest.mark.parametrize("slower", [0.1, 0.01, 0.001])
def test_slow_drives_with_strong_motors_are_planned(path: Path, slower: float) -> None:
    """Where starting takes next to no time, the duration is what velocities make it."""
    slow = _with_limits(path, velocity=slower)
    s = np.linspace(0.0, 1.0, 20_001)
    cruising = (np.abs(path.q(s, 1)) / slow.machine.velocity_mps).max(axis=1).mean()
    assert plan(slow, 2_000).duration_s == pytest.approx(cruising, rel=0.05 * slower / 0.1 + 1e-3)


@pytest.mark.parametrize("waves", [1, 8])
def test_a_path_that_stops_has_a_plan_and_nothing_is_printed(line, waves: int, capfd) -> None:
    """Where q'(s) vanishes the path speed peaks: the plan goes through, and takes longer than the line by itself."""
    stopping = line(0.9, lambda s: s - np.sin(2.0 * np.pi * waves * (s - 0.5)) / (2.0 * np.pi * waves), 400)
    assert 2.05 < plan(stopping, 4_000).duration_s < 2.0 * 2.05
    assert capfd.readouterr() == ("", "")


def test_only_rest_beyond_a_limit_has_no_plan(path: Path) -> None:
    """Gravity that takes more than a drive has is refused with the drive, its share and the place."""
    weak = replace(path, machine=replace(path.machine, force_n=np.array([100.0, 400.0, 400.0, 1_000.0, 1_000.0])))
    with pytest.raises(NoSolutionError, match=r"c1 needs 156\.\d% of its force limit at rest at s = 0\.\d+") as caught:
        plan(weak, 500)
    assert caught.value.stage == "retime"
    assert caught.value.diagnosis["limit"] == "force"
    assert 0.0 <= caught.value.diagnosis["s"] <= 1.0
