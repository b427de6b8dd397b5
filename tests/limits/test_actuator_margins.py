"""Margins at the ends of rails and strokes: where they hold, and where the task has less."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import ConfigError
from pipeline.limits.actuator_margins import given_positions_m, planned_range_m, within_margins
from pipeline.limits.actuators import for_path
from pipeline.machine import Machine, build_machine
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions
from tests.conftest import CONFIGS


@given(travel=st.floats(0.0, 1.0), stroke=st.floats(0.0, 0.14), shift=st.floats(-0.02, 0.02))
def test_the_path_keeps_the_margins_or_what_the_task_leaves(agder_config, machine, vary, travel, stroke, shift):
    """Of every actuator and end: the margin, or the least distance of start, goal and visits, whichever is less."""
    visit = {"x_m": 1.0 + shift, "y_m": 0.35, "z_m": 0.85, "mode": "LLL"}
    changes = {"refine.travel_margin_m": travel, "refine.stroke_margin_m": stroke, "task.visit": [{"pose": visit}]}
    config = vary(agder_config, changes)
    q = given_positions_m(config, machine)
    assert q.shape == (3, 5)
    least, largest = machine.actuator_limits_m.T
    margin = np.array([travel] * 3 + [stroke] * 2)
    left = np.minimum(margin, q - least).min(axis=0), np.minimum(margin, largest - q).min(axis=0)
    np.testing.assert_allclose(planned_range_m(config, machine), np.stack([least + left[0], largest - left[1]], axis=1))


def test_poses_beyond_the_machine_widen_nothing(agder_config: Config, machine: Machine, vary):
    """Neither those out of reach nor those that no cart can get to."""
    own = planned_range_m(agder_config, machine)
    for x_m, z_m in ((1.02, 15.0), (9.0, 0.9)):
        far = vary(agder_config, {"task.goal.x_m": x_m, "task.goal.z_m": z_m})
        found = planned_range_m(far, machine)
        limits = machine.actuator_limits_m
        assert ((found >= limits[:, :1]) & (found <= limits[:, 1:])).all()
        if z_m > 2.0:
            np.testing.assert_array_equal(found, own)


@pytest.mark.parametrize(("travel", "stroke"), [(0.0, 0.0), (0.1, 0.09)])
def test_regions_keep_them(vary, travel: float, stroke: float):
    """All but the task's own rows; without margins there are regions right at the ends."""
    changes = {"refine.travel_margin_m": travel, "refine.stroke_margin_m": stroke, "task.tilt_max_deg": 10}
    changes |= {"route.grid.rx_step_deg": 10, "route.grid.rz_step_deg": 10}
    config = vary(load_config(CONFIGS / "tiny.yaml"), changes)
    machine = build_machine(config.machine)
    table = build_regions(config, machine)
    grid, ends = table.take(np.arange(len(table) - 2)), table.take(np.arange(len(table) - 2, len(table)))
    left = []
    for side in (0, 1):
        q = grid.q_m.copy()
        q[:, :3] += grid.x_window_m[:, side : side + 1]
        limits = machine.actuator_limits_m
        left.append(np.minimum(q - limits[:, 0], limits[:, 1] - q))
    assert np.min(left, axis=0)[:, :3].min() == pytest.approx(travel, abs=1e-9)
    assert np.min(left, axis=0)[:, 3:].min() >= stroke - 1e-9
    # Of the strokes, the regions of this grid use all but 72 mm by themselves.
    assert np.min(left, axis=0)[:, 3:].min() < max(stroke, 0.07) + 0.03
    # The start's first cart is 20 mm from the end of its rail.
    assert ends.q_m[0, 0] < 0.1
    assert (ends.x_window_m[:, 0] == ends.x_window_m[:, 1]).all()


def test_a_path_limit_is_the_planned_range(agder_config: Config, machine: Machine, vary):
    """A pose within the machine's travel, but not within the margin, breaks it."""
    config = vary(agder_config, {"refine.travel_margin_m": 0.05})
    (limit,) = for_path(config, machine)
    for c2, kept in ((0.051, True), (0.049, False), (2.051, False)):
        q = np.array([[1.0, c2, 1.0, 1.1, 1.2]])
        assert bool((limit.margins(PoseSamples(machine, np.zeros((1, 6)), q)) >= 0.0).all()) == kept


def test_the_shortened_machine_is_the_same_otherwise(agder_config: Config, machine: Machine):
    """Only travel and strokes change, by the defaults of a builder."""
    short = within_margins(agder_config, machine)
    change = short.actuator_limits_m - machine.actuator_limits_m
    np.testing.assert_allclose(change, np.array([[0.005, -0.005]] * 3 + [[0.002, -0.002]] * 2))
    same = [name for name in vars(machine) if name not in ("travel_m", "strokes_m")]
    assert all(getattr(short, name) is getattr(machine, name) for name in same)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("stroke_margin_m", 0.16, "is 0.16, which leaves nothing of machine.links.l2b.stroke_m [0.95, 1.25]; allowed"),
        ("travel_margin_m", 1.0, "is 1, which leaves nothing of machine.rails[1].travel_m [0.2, 2.1]; allowed is less"),
        ("travel_margin_m", -0.001, "is -0.001; allowed is a number from 0 to 1"),
    ],
)
def test_margins_that_leave_nothing_are_refused(agder_config: Config, vary, key: str, value: float, message: str):
    """With the key, its value and what would be allowed."""
    with pytest.raises(ConfigError) as error:
        vary(agder_config, {f"refine.{key}": value, "machine.rails.1.travel_m": [0.2, 2.1]})
    assert [issue.path for issue in error.value.issues] == [f"refine.{key}"]
    assert error.value.issues[0].message.startswith(message)
