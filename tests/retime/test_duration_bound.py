"""The lower bound: below every motion, near the fastest, exact in the limit where the fastest is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import NoSolutionError
from pipeline.machine import Machine
from pipeline.refine.result import Path
from pipeline.retime import measure_usage
from pipeline.retime.duration_bound import duration_bound
from pipeline.retime.fastest import plan
from pipeline.retime.path_dynamics import grid, tabulate_dynamics


def _bound(path: Path, points: int) -> float:
    return duration_bound(tabulate_dynamics(path, grid(1_001)), grid(points))


@pytest.mark.parametrize("travel_m", [0.9, 0.3, 0.1, 0.01])
def test_a_line_is_bounded_by_what_it_takes(line, machine: Machine, travel_m: float) -> None:
    """Below D / v + v / a, or 2 sqrt(D / a), by less than half a percent on a thousand points."""
    v, a = machine.velocity_mps[0], machine.acceleration_mps2[0]
    exact = travel_m / v + v / a if travel_m > v**2 / a else 2.0 * np.sqrt(travel_m / a)
    bound = _bound(line(travel_m), 1_000)
    assert exact * 0.995 < bound <= exact * (1.0 + 1e-7)


@pytest.mark.parametrize("points", [20, 50, 55, 100, 1_000])
def test_a_line_run_through_unevenly_is_bounded_on_coarse_grids_too(line, machine: Machine, points: int) -> None:
    """However much the speed along s changes within a cell, what every motion keeps is not more than it does keep."""
    k, part, phase, travel_m = 5.844, 0.911, 3.139, 0.9
    path = line(travel_m, lambda s: s - part / (k * 2.0 * np.pi) * np.cos(2.0 * np.pi * k * s + phase), points=175)
    path = replace(path, machine=replace(machine, masses=None))
    exact = travel_m / machine.velocity_mps[0] + machine.velocity_mps[0] / machine.acceleration_mps2[0]
    bound = duration_bound(tabulate_dynamics(path, grid(2_001)), grid(points))
    assert 0.5 * exact < bound <= exact * (1.0 + 1e-7)


def test_every_grid_gives_a_bound_and_finer_ones_come_nearer(path: Path) -> None:
    """From coarse to fine it rises, never above the fastest law that is found; the gap falls with the first order."""
    fastest = plan(path, 8_000).duration_s
    points = np.array([100, 200, 400, 800, 1_600])
    gaps = 1.0 - np.array([_bound(path, n) for n in points]) / fastest
    assert np.all(gaps > 0.0)
    assert np.all(np.diff(gaps) < 0.0)
    assert gaps[-1] < 0.005
    assert -np.polyfit(np.log(points), np.log(gaps), 1)[0] > 0.7


def test_forces_and_tcp_count(path: Path) -> None:
    """Tighter limits raise the bound, and it stays below the fastest law under them."""
    tight = replace(path, machine=replace(path.machine, tcp_speed_mps=0.25, tcp_acceleration_mps2=0.5))
    assert _bound(path, 500) < _bound(tight, 500) < plan(tight, 2_000).duration_s
    force = np.array([180.0, 150.0, 150.0, 1_000.0, 1_000.0])
    weak = replace(path, machine=replace(path.machine, force_n=force))
    assert _bound(path, 500) <= _bound(weak, 500) < plan(weak, 4_000).duration_s * (1.0 + 1e-4)


@settings(max_examples=15)
@given(exponent=st.floats(-3.0, 3.0))
def test_the_bound_scales_with_the_clock(path: Path, exponent: float) -> None:
    """Velocities times k and accelerations times k^2 divide it by k, without masses."""
    k = 10.0**exponent
    machine = replace(path.machine, masses=None)
    fast = replace(machine, velocity_mps=machine.velocity_mps * k, acceleration_mps2=machine.acceleration_mps2 * k**2)
    one, other = (_bound(replace(path, machine=used), 200) for used in (machine, fast))
    assert other * k == pytest.approx(one, rel=1e-3)


def test_without_any_motion_there_is_no_bound(path: Path) -> None:
    """Where gravity takes more than a drive has, no x(s) exists."""
    weak = replace(path, machine=replace(path.machine, force_n=np.full(5, 30.0)))
    with pytest.raises(NoSolutionError, match="no motion along the path"):
        _bound(weak, 200)


@pytest.mark.parametrize("points", [1_000, 10_000])
def test_with_a_limit_of_the_tcp_a_line_is_bounded_by_what_it_takes(line, machine: Machine, points: int) -> None:
    """2 sqrt(D / a), however fine the grid: the circle of accelerations has to be inside of what stands for it."""
    slow = replace(machine, tcp_acceleration_mps2=0.5, masses=None)
    path, exact = replace(line(0.1), machine=slow), 2.0 * np.sqrt(0.1 / 0.5)
    bound = duration_bound(tabulate_dynamics(path, grid(max(points, 2_001))), grid(points))
    assert exact * 0.999 < bound <= exact * (1.0 + 1e-7)


@pytest.mark.parametrize("speed_mps", [0.01, 0.003])
def test_a_slow_motion_is_not_faster_than_its_bound(path: Path, speed_mps: float) -> None:
    """Where the TCP's speed decides nearly everywhere, bound and law come together, in this order."""
    slow = replace(path, machine=replace(path.machine, tcp_speed_mps=speed_mps, masses=None))
    law = plan(slow, 8_000)
    held = law.duration_s * measure_usage(law).stretch
    assert held * (1.0 - 1e-3) < _bound(slow, 1_000) <= held * (1.0 + 1e-7)
