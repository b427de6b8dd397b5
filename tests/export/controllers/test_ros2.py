"""Joint trajectories by the rules by which joint_trajectory_controller accepts one, written down here once more."""

import json
import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from pipeline.export import ExportOptions, ExportRequest, format_json, format_yaml, read_joint_trajectory
from pipeline.export.controllers.cam import hermite
from pipeline.export.controllers.ros2 import joint_trajectory
from pipeline.machine.geometry import ACTUATORS
from pipeline.retime import TrajectorySamples

LIMITS = np.array([2.0, 2.0, 2.0, 0.5, 0.5])


def rejection(message: dict[str, Any], joints: tuple[str, ...]) -> str | None:
    """Say why the controller would reject a message, as `validate_trajectory_msg` does with default parameters."""
    names, points = message["joint_names"], message["points"]
    times = [point["time_from_start"]["sec"] * 10**9 + point["time_from_start"]["nanosec"] for point in points]
    sizes = [{len(point[name]) for point in points} for name in ("positions", "velocities", "accelerations")]
    if sorted(names) != sorted(joints):
        return "joints"
    if not points:
        return "no points"
    if any(abs(speed) > np.finfo(np.float32).eps for speed in points[-1]["velocities"]):
        return "velocity at the end"
    if message["header"]["stamp"] != {"sec": 0, "nanosec": 0}:
        return "starts in the past"
    if any(late <= early for early, late in pairwise(times)):
        return "times"
    if sizes[0] != {len(joints)} or any(size - {0, len(joints)} for size in sizes[1:]):
        return "sizes"
    if any(point.get("effort") for point in points):
        return "effort"
    return None


@pytest.mark.parametrize("lead_in_s", [0.0, 1.5])
def test_the_controller_accepts_it(reference: TrajectorySamples, lead_in_s: float) -> None:
    """None of its rules rejects the reference motion."""
    request = ExportRequest(reference, LIMITS, ACTUATORS, ExportOptions(lead_in_s=lead_in_s))
    assert rejection(json.loads(format_json(request)), ACTUATORS) is None


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda message: message["joint_names"].pop(), "joints"),
        (lambda message: message["points"].clear(), "no points"),
        (lambda message: message["points"][-1]["velocities"].__setitem__(0, 1e-3), "velocity at the end"),
        (lambda message: message["points"].append(message["points"][-1]), "times"),
        (lambda message: message["points"][3]["positions"].pop(), "sizes"),
        (lambda message: message["points"][3].update(effort=[1.0]), "effort"),
    ],
)
def test_the_rules_reject_what_they_should(make_samples, spoil: Callable[[dict], Any], reason: str) -> None:
    """The check above can fail."""
    message = joint_trajectory(ExportRequest(make_samples(0.01), LIMITS, ACTUATORS))
    spoil(message)
    assert rejection(message, ACTUATORS) == reason


def test_a_lead_in_shifts_all_points(make_samples) -> None:
    """The first point is that much later, and so are all others; positions stay."""
    samples = make_samples(0.01)
    request = ExportRequest(samples, LIMITS, ACTUATORS, ExportOptions(lead_in_s=1.25))
    motion = read_joint_trajectory(format_yaml(request))
    assert motion.t_s == pytest.approx(samples.t_s + 1.25, abs=1e-9)
    assert motion.q_m == pytest.approx(samples.q_m, abs=1e-15)
    first = re.search(r"time_from_start: \{sec: (\d+), nanosec: (\d+)\}", format_yaml(request))
    assert first is not None
    assert first.groups() == ("1", "250000000")


def test_quintics_between_points_add_little_jerk(reference: TrajectorySamples) -> None:
    """What the controller drives between points 10 ms apart stays within the accelerations and a tenth of the jerk."""
    fine = np.linspace(0.0, reference.t_s[-1], 20 * len(reference))
    for k, (acceleration, jerk) in enumerate([(2.0, 40.0)] * 3 + [(0.5, 10.0)] * 2):
        points = np.stack([values[:, k] for values in (reference.q_m, reference.qd_mps, reference.qdd_mps2)], axis=1)
        found = np.abs(hermite(reference.t_s, points, fine)).max(axis=0)
        assert found[2] <= 1.01 * acceleration
        assert found[3] <= 1.1 * jerk
