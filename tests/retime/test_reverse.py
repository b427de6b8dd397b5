"""The way back: the same motion backwards, with its own check."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config, RetimeConfig
from pipeline.refine.result import Path
from pipeline.retime import Trajectory, measure_usage, retime_path, time_reversed, way_back
from pipeline.retime.toppra import plan


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
    assert other.force == pytest.approx(one.force, rel=1e-6)
    assert other.velocity == pytest.approx(one.velocity, rel=1e-6)


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
