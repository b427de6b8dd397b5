"""All that a task may ask for, kept by motions whose path and time law are found together: at nodes and between."""

from typing import Any

import numpy as np
import pytest

from pipeline.certify import certify_path
from pipeline.config import Config
from pipeline.limits.avoid import Box
from pipeline.machine import Machine, build_machine
from pipeline.refine import PathSamples, measure_path, refine_path, sample_path
from pipeline.retime import measure_usage, retime_path, way_back
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes

TAU = np.linspace(0.0, 1.0, 100_001)
APPROACH_M = 0.05


def _asked(light_config: Config, machine: dict[str, Any], task: dict[str, Any], refine: dict[str, Any]) -> Config:
    """Ask for the least duration, and for more."""
    document = light_config.model_dump(mode="json")
    document["machine"]["dynamics"] |= machine
    document["task"] |= task
    document["refine"] |= {"objective": "time", **refine}
    return Config.model_validate(document)


def _angles_deg(samples: PathSamples, direction: np.ndarray) -> np.ndarray:
    """Compute the angles of the chords to the goal within the approach, by the direction in which it is reached."""
    chords = samples.pose[-1, :3] - samples.pose[:, :3]
    lengths = np.linalg.norm(chords, axis=1)
    last = np.flatnonzero(lengths > APPROACH_M)[-1] + 1
    near = (np.arange(len(lengths)) >= last) & (lengths > 1e-5)
    return np.rad2deg(np.arccos(np.clip(chords[near] @ direction / lengths[near], -1.0, 1.0)))


@pytest.mark.slow
def test_boxes_and_a_direction_are_kept_within_a_budget(light_config: Config, machine: Machine) -> None:
    """A box is visited, one is avoided, no arm changes its mode, and the goal is reached straight."""
    visit, avoid = {"y_m": [0.45, 0.55], "z_m": [0.70, 0.75]}, {"y_m": [0.45, 0.55], "z_m": [0.85, 0.95]}
    goal = {**light_config.task.start.model_dump(mode="json"), "y_m": 0.7}
    task = {"goal": goal, "visit": [{"box": visit}], "avoid": [avoid], "budget": {"mode_changes": 0}}
    ends = {"goal_direction": [0.0, 0.0, 1.0], "approach_m": APPROACH_M}
    config = _asked(light_config, {}, task, ends)
    path = refine_path(config, machine, plan_route(config, machine, build_regions(config, machine))).path
    samples = sample_path(path, TAU)
    visited = Box.of(config.task.visit[0].box)
    assert visited.grown(np.full(5, 1e-6)).inside(samples.controlled).any()
    assert Box.of(config.task.avoid[0]).depth_m(samples.controlled).max() <= 0.0
    assert measure_path(samples, step_sizes(config.route)).mode_changes == 0
    assert _angles_deg(samples, np.array([0.0, 0.0, 1.0])).max() <= 3.0
    certify_path(config, machine, path)


@pytest.mark.slow
def test_a_locked_axis_and_friction_are_kept_there_and_back(light_config: Config) -> None:
    """The tolerance of the axis at every instant, and forces with friction in both directions."""
    friction = {"friction": {"carts_n": 30.0, "telescopes_n": 40.0}}
    config = _asked(light_config, friction, {"locked_axes": ["rx"]}, {"kappa_max": 60.0})
    machine = build_machine(config.machine)
    path = refine_path(config, machine, plan_route(config, machine, build_regions(config, machine))).path
    samples = sample_path(path, TAU)
    assert np.rad2deg(np.abs(samples.pose[:, 3]).max()) <= config.refine.lock_tolerance_deg
    assert samples.kappa.max() <= 60.0
    there = retime_path(config, path)
    back = way_back(config, there)
    for trajectory in (there, back):
        assert measure_usage(trajectory, config.retime.period_s).largest <= 1.001
    assert there.timing is not None
    assert there.timing.motion_s <= float(path.motion_s or 0.0) * (1.0 + 1e-9)
