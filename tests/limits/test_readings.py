"""What limits read at a pose: the same quantities and signs as their margins, and a room that compares."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.limits import Reading, admits, read_limits, task_pose_limits
from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples


def reading(value: float, least: float = -np.inf, largest: float = np.inf) -> Reading:
    """Make a reading of nothing in particular."""
    return Reading("it", "m", value, least, largest, "", "")


@pytest.mark.parametrize(
    ("given", "margin", "room"),
    [
        (reading(1.0, 0.0, 2.0), 1.0, 1.0),
        (reading(0.5, 0.0, 2.0), 0.5, 0.5),
        (reading(2.5, 0.0, 2.0), -0.5, -0.5),
        (reading(25.0, largest=100.0), 75.0, 0.75),
        (reading(125.0, largest=100.0), -25.0, -0.2),
        (reading(0.04, least=0.03), 0.01, 0.25),
        (reading(0.0, least=0.03), -0.03, -1.0),
        (reading(-2.0, least=-5.0), 3.0, 0.6),
        (reading(50.0, least=-5.0), 55.0, 1.0),
        (reading(np.inf, largest=100.0), -np.inf, -1.0),
        (reading(0.0, largest=0.0), 0.0, 0.0),
    ],
)
def test_margin_and_room(given: Reading, margin: float, room: float) -> None:
    """The margin is in the unit; the room is 0 at a limit, 1 in the middle of two or far from one."""
    assert given.margin == pytest.approx(margin)
    assert given.room == pytest.approx(room)


def test_readings_agree_with_the_limits(machine: Machine, quick_config: Config, vary, draw_poses) -> None:
    """At random poses each limit is kept exactly where none of its readings is beyond."""
    box = {"y_m": [0.2, 0.6], "z_m": [0.6, 1.0]}
    config = vary(quick_config, {"task.avoid": [box], "task.tilt_max_deg": 20.0, "route.kappa_max": 40.0})
    sample = draw_poses(machine, 7, 60, kappa_max=1e3)
    limits = task_pose_limits(config, machine)
    states = set()
    for pose, q in zip(sample.pose, sample.q_m, strict=True):
        samples = PoseSamples(machine, pose[None], q[None])
        for limit in limits:
            kept = bool(admits(limit, samples)[0])
            assert kept == all(one.margin >= 0.0 for one in read_limits([limit], samples)), limit.wording.name
            states.add((limit.wording.name, kept))
    names = {limit.wording.name for limit in limits}
    assert {"kappa", "tilt", "box to avoid", "actuator position", "link-link distance", "holding force"} <= names
    assert {("kappa", False), ("tilt", False), ("box to avoid", False), ("actuator position", False)} <= states


def test_the_nearest_pair_is_named(machine: Machine, quick_config: Config, draw_poses) -> None:
    """A distance is that of the pair it names, and every actuator has a reading of its own."""
    sample = draw_poses(machine, 8, 5)
    samples = PoseSamples(machine, sample.pose[:1], sample.q_m[:1])
    found = {one.name: one.value for one in read_limits(task_pose_limits(quick_config, machine), samples)}
    (distance,) = (value for name, value in found.items() if name.startswith("link-link distance (links "))
    assert distance == samples.link_distance_m[0]
    np.testing.assert_array_equal([found[name] for name in ("c1", "c2", "c3", "l2b", "l3b")], samples.q_m[0])


def test_a_limit_without_curves_reads_its_excess(machine: Machine, quick_config: Config, draw_poses) -> None:
    """A kind that only has margins still says how far beyond its limit a pose is."""

    class Bare:
        def __init__(self, limit: object) -> None:
            self.wording = limit.wording
            self.excess = limit.excess

    sample = draw_poses(machine, 8, 5)
    samples = PoseSamples(machine, sample.pose[:1], sample.q_m[:1])
    kappa = next(one for one in task_pose_limits(quick_config, machine) if one.wording.name == "kappa")
    (found,) = read_limits([Bare(kappa)], samples)
    assert found.margin == pytest.approx(quick_config.route.kappa_max - samples.kappa[0])
