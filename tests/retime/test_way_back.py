"""The way back: the same motion backwards; where friction makes it harder, timed by itself or refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.config import Config, RetimeConfig
from pipeline.errors import NoSolutionError
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_usage, retime_path, time_reversed, way_back
from pipeline.retime.fastest import plan
from pipeline.retime.path_dynamics import evaluate_dynamics


def _config(config: Config, **options: Any) -> Config:
    return config.model_copy(update={"retime": RetimeConfig(jerk=False, **options)})


@pytest.fixture(scope="module")
def needed(path: Path) -> dict[str, np.ndarray]:
    """Forces of the drives against gravity and friction, there and back."""
    rubbing = _rubbing(path, np.full(5, 2_000.0))
    dynamics = evaluate_dynamics(rubbing, np.linspace(0.0, 1.0, 2_001))
    gravity, friction = dynamics.c[:, :5], dynamics.friction()
    return {"there": np.abs(gravity + friction).max(axis=0), "back": np.abs(gravity - friction).max(axis=0)}


def _rubbing(path: Path, force_n: np.ndarray) -> Path:
    masses = replace(path.machine.masses, friction_n=np.full(5, 60.0))
    return replace(path, machine=replace(path.machine, masses=masses, force_n=force_n))


def _weak(path: Path, needed: dict[str, np.ndarray], part: float) -> tuple[Path, int]:
    """Limit the drive for which the way back is hardest to what it needs there (0) to what it needs back (1)."""
    drive = int(np.argmax(needed["back"] / needed["there"]))
    assert needed["back"][drive] > 1.02 * needed["there"][drive]
    force = np.full(5, 2_000.0)
    force[drive] = (1.0 - part) * needed["there"][drive] + part * needed["back"][drive]
    return _rubbing(path, force), drive


def test_an_impossible_way_back_is_reported_as_such(
    agder_config: Config, path: Path, needed: dict[str, np.ndarray]
) -> None:
    """The way there works; the error names the way back, with s along the way there, and does not mention holding."""
    weak, drive = _weak(path, needed, 0.5)
    config = _config(agder_config)
    there = retime_path(config, weak)
    with pytest.raises(
        NoSolutionError, match=r"^retime: on the way back, .* against gravity and dry friction"
    ) as caught:
        way_back(config, there)
    dynamics = evaluate_dynamics(weak, np.linspace(0.0, 1.0, 2_001))
    back = np.abs(dynamics.c[:, :5] - dynamics.friction())[:, drive]
    assert caught.value.diagnosis["s"] == pytest.approx(dynamics.s[np.argmax(back)], abs=1e-3)
    assert "hold" not in caught.value.reason


@pytest.mark.parametrize("speed", [1.0, 0.5])
def test_a_way_back_that_would_be_far_too_slow_is_timed_by_itself(
    agder_config: Config, path: Path, needed: dict[str, np.ndarray], speed: float
) -> None:
    """Drives that can hardly move back somewhere are waited for there, and not everywhere; limits and dwells hold."""
    weak, _ = _weak(path, needed, 1.0005)
    config = _config(agder_config, speed=speed, dwell_s=(0.5, 0.2))
    there = retime_path(config, weak)
    back = way_back(config, there)
    assert back.dwell_s == there.dwell_s[::-1]
    assert there.motion_s < back.motion_s < 1.3 * there.motion_s
    assert measure_usage(back, 0.01).largest <= 1.001
    assert back.q(0.0) == pytest.approx(there.q(there.duration_s))
    assert back.q(back.duration_s) == pytest.approx(there.q(0.0))


@pytest.fixture(scope="module", params=[True, False], ids=["jerk", "no jerk"])
def trajectory(request: pytest.FixtureRequest, agder_config: Config, path: Path) -> Trajectory:
    """The curve in time, with a dwell at each end."""
    options = RetimeConfig(jerk=request.param, jerk_pieces=100, dwell_s=(0.2, 0.5))
    return retime_path(agder_config.model_copy(update={"retime": options}), path)


def test_it_is_the_same_motion_backwards(trajectory: Trajectory) -> None:
    """q(T - t) and its derivatives, signs changing with every odd one; dwells change places."""
    back = time_reversed(trajectory)
    assert back.duration_s == trajectory.duration_s
    assert back.dwell_s == (0.5, 0.2)
    t = np.linspace(0.011, trajectory.duration_s - 0.013, 700)
    breaks = np.abs(t[:, None] - 0.2 - trajectory.time_law.x).min(axis=1) > 1e-6
    t = t[breaks]
    for order in range(3):
        there = trajectory.q(t, order) * (-1.0) ** order
        assert back.q(back.duration_s - t, order) == pytest.approx(there, abs=1e-8)


def test_reversing_twice_is_where_it_began(trajectory: Trajectory) -> None:
    """Path and law come back to rounding."""
    again = time_reversed(time_reversed(trajectory))
    t = np.linspace(0.0, trajectory.duration_s, 300)
    assert again.q(t) == pytest.approx(trajectory.q(t), abs=1e-12)
    assert again.pose(t) == pytest.approx(trajectory.pose(t), abs=1e-9)


def test_forces_without_friction_are_the_same_both_ways(trajectory: Trajectory) -> None:
    """Inertia and gravity do not know the direction of time."""
    one, other = measure_usage(trajectory), measure_usage(time_reversed(trajectory))
    assert other.fractions["force"] == pytest.approx(one.fractions["force"], rel=1e-6)
    assert other.fractions["velocity"] == pytest.approx(one.fractions["velocity"], rel=1e-6)


def test_with_friction_the_way_back_may_take_longer(agder_config: Config, path: Path) -> None:
    """A drive just strong enough one way is not so the other: the way back is slower then, and keeps all limits."""
    masses = replace(path.machine.masses, friction_n=np.array([60.0, 60.0, 60.0, 0.0, 0.0]))
    strong = replace(path.machine, masses=masses, force_n=np.full(5, 1_000.0))
    there = plan(replace(path, machine=strong), 1_000)
    peaks = {way: measure_usage(one).peaks["force"] for way, one in (("there", there), ("back", time_reversed(there)))}
    harder = int(np.argmax(peaks["back"] / peaks["there"]))
    assert peaks["back"][harder] > 1.01 * peaks["there"][harder]
    limit = np.full(5, 1_000.0)
    limit[harder] = 1.005 * peaks["there"][harder]
    weak = replace(path, machine=replace(strong, force_n=limit))
    config = agder_config.model_copy(update={"retime": RetimeConfig(jerk=False)})
    one = retime_path(config, weak)
    back = way_back(config, one)
    assert back.duration_s >= one.duration_s
    assert measure_usage(back, 0.01).largest <= 1.001
