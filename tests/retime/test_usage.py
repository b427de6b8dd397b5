"""Usage of limits: measured between the grid points, on both sides of jumps, and insisted on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import (
    Trajectory,
    Usage,
    measure_trajectory,
    measure_usage,
    require_limits,
    sample_trajectory,
    stretched,
    time_reversed,
)
from pipeline.retime.fastest import plan


@pytest.fixture(scope="module")
def planned(path: Path) -> Trajectory:
    """The fastest law along the curve, as planned."""
    return plan(path, 1_000)


def test_usage_agrees_with_brute_force(planned: Trajectory) -> None:
    """Evaluating a hundred thousand instants finds no more, and hardly less."""
    t = np.linspace(0.0, planned.duration_s, 100_001)
    machine = planned.path.machine
    usage = measure_usage(planned)
    velocity = np.abs(planned.q(t, 1) / machine.velocity_mps).max(axis=0)
    acceleration = np.abs(planned.q(t, 2) / machine.acceleration_mps2).max(axis=0)
    assert velocity == pytest.approx(usage.fractions["velocity"], rel=2e-5)
    assert acceleration == pytest.approx(usage.fractions["acceleration"], rel=1e-3)
    assert np.all(velocity <= usage.fractions["velocity"] + 1e-6)
    assert np.all(acceleration <= usage.fractions["acceleration"] + 1e-5)


def test_both_sides_of_a_jump_are_evaluated(line) -> None:
    """A law that brakes harder than it accelerates shows it, though the evaluation takes jumps from the right."""
    path = line(0.9)
    # Speeding up for two thirds of the time, braking twice as hard for the last third.
    sdd = 0.5
    t = np.array([0.0, 2.0, 3.0])
    s = np.array([0.0, sdd * 2.0, sdd * 3.0])
    law = Trajectory.from_breakpoints(
        path, t, s / s[-1], np.array([0.0, 2.0 * sdd, 0.0]) / s[-1], np.array([sdd, -2.0 * sdd, 0.0]) / s[-1]
    )
    expected = 0.9 * 2.0 * sdd / s[-1] / path.machine.acceleration_mps2[:3]
    assert measure_usage(law).fractions["acceleration"][:3] == pytest.approx(expected)
    assert measure_usage(law).fractions["acceleration"][3:] == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=25)
@given(factor=st.floats(0.2, 10.0))
def test_usage_follows_the_stretch(planned: Trajectory, factor: float) -> None:
    """In f times the time, velocity usage is divided by f and acceleration usage by f^2."""
    before, after = measure_usage(planned), measure_usage(stretched(planned, planned.duration_s * factor))
    assert after.fractions["velocity"] * factor == pytest.approx(before.fractions["velocity"], rel=1e-9)
    assert after.fractions["acceleration"] * factor**2 == pytest.approx(before.fractions["acceleration"], rel=1e-9)


@given(st.lists(st.floats(0.0, 4.0), min_size=10, max_size=10))
def test_the_stretch_is_the_least_that_makes_all_limits_hold(fractions: list[float]) -> None:
    """After it no fraction is above one; without need it is one; where it is more, a limit is just reached."""
    usage = Usage({"velocity": np.array(fractions[:5]), "acceleration": np.array(fractions[5:])})
    f = usage.stretch
    after = max((usage.fractions["velocity"] / f).max(), (usage.fractions["acceleration"] / f**2).max())
    assert after <= 1.0 + 1e-12
    assert f == 1.0 or after == pytest.approx(1.0)


def test_a_planned_law_passes(planned: Trajectory) -> None:
    """What the planner made on a fine grid keeps all limits, and its usage is returned."""
    assert require_limits(planned).largest == measure_usage(planned).largest == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("factor", [0.9, 0.5])
def test_an_exceeded_acceleration_is_reported(planned: Trajectory, factor: float) -> None:
    """Who, what, how much of what, and where; the place named is where it happens."""
    fast = stretched(planned, planned.duration_s * factor)
    with pytest.raises(NoSolutionError, match=r"of its acceleration limit of .* at s = .*, t = ") as caught:
        require_limits(fast)
    diagnosis = caught.value.diagnosis
    assert diagnosis["limit"] == "acceleration"
    assert diagnosis["fraction"] == pytest.approx(1.0 / factor**2, rel=1e-3)
    assert diagnosis["s"] == pytest.approx(float(fast.s(diagnosis["t_s"])))
    assert "smoother path" in caught.value.advice


def test_an_exceeded_velocity_is_reported(line) -> None:
    """On a slow long line with gentle acceleration it is the velocity that is named, of the cart that has it."""
    path = line(2.0)
    law = Trajectory.from_breakpoints(
        path,
        np.array([0.0, 1.5, 3.0]),
        np.array([0.0, 0.5, 1.0]),
        np.array([0.0, 1.0 / 1.5, 0.0]),
        np.array([1.0, -1.0, 0.0]) / 1.5**2,
    )
    with pytest.raises(
        NoSolutionError, match=r"c[123] would reach 1\.333 m/s, 266\.7% of its velocity limit of 0\.5"
    ) as e:
        require_limits(law)
    assert e.value.diagnosis["t_s"] == pytest.approx(1.5)


def test_figures_are_those_of_the_samples_and_the_law(planned: Trajectory) -> None:
    """Duration, period and number of rows; usage of the trajectory itself, denser than the rows."""
    samples = sample_trajectory(planned, 0.01)
    figures = measure_trajectory(planned, samples)
    assert (figures.duration_s, figures.period_s, figures.samples) == (samples.t_s[-1], 0.01, len(samples))
    assert figures.usage.largest == measure_usage(planned).largest


@pytest.mark.parametrize("period_s", [0.01, 0.001])
def test_the_jump_from_standstill_is_seen_as_that_to_standstill(planned: Trajectory, period_s: float) -> None:
    """What a controller sees of a law and of the same law backwards is the same: both begin and end with a jump."""
    there, back = (measure_usage(one, period_s).peaks["jerk"] for one in (planned, time_reversed(planned)))
    starts = np.abs(planned.q(0.0, 2)) / period_s
    assert np.all(there >= starts * (1.0 - 1e-9))
    assert there == pytest.approx(back, rel=0.05)
