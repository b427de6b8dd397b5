"""What counting alone excludes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.machine import Machine, build_machine
from pipeline.route import Route, build_regions, plan_route
from pipeline.route.metric import step_sizes
from pipeline.route.regions.counting import counting_issues, require_possible_task
from pipeline.route.regions.endpoints import task_endpoints

POSE = {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9}


def issues(config: Config) -> dict[str, str]:
    """Give the issues by key."""
    return {issue.path: issue.message for issue in counting_issues(config)}


@pytest.mark.parametrize(
    ("values", "key", "words"),
    [
        ({"task.budget.mode_changes": 2}, "task.budget.mode_changes", "from LLL to RRR takes at least 3"),
        (
            {
                "task.budget.mode_changes": 4,
                "task.visit": [{"pose": POSE | {"mode": "RLL"}}, {"box": {"y_m": [0, 1]}, "modes": ["LRL", "LRR"]}],
            },
            "task.budget.mode_changes",
            "over its visits takes at least 5",
        ),
        ({"route.step_budget": 4}, "route.step_budget", "at least 5 positions are needed"),
        (
            {"task.goal.x_m": 1.6, "route.step_budget": 6},
            "route.step_budget",
            "at least 7 positions are needed: 6 moves from the start to the goal (x changes",
        ),
        (
            {"task.visit": [{"pose": POSE | {"z_m": 1.4, "mode": "LLL"}}], "route.step_budget": 9},
            "route.step_budget",
            "at least 11 positions are needed: 5 moves from the start to task.visit[0] (z changes by at most one grid "
            "step a move), 5 moves from task.visit[0] to the goal",
        ),
        ({"task.goal.x_m": 1.3, "task.budget.travel_m": 0.2}, "task.budget.travel_m", "takes 0.28 at least"),
        (
            {"task.visit": [{"box": {"y_m": [0.5, 0.7], "z_m": [0.0, 1.2]}}], "task.budget.travel_m": 0.39},
            "task.budget.travel_m",
            "takes 0.4 at least",
        ),
        ({"task.goal.rx_deg": 20, "task.goal.rz_deg": -5, "task.budget.tilt_deg": 24}, "task.budget.tilt_deg", "25 at"),
        ({"task.visit": [{"box": {"y_m": [3, 4]}}]}, "task.visit[0].box.y_m", "off the grid, which has -0.4 to 1.2"),
        ({"task.visit": [{"box": {"rx_deg": [31, 40]}}]}, "task.visit[0].box.rx_deg", "has -30 to 30"),
        (
            {"task.visit": [{"box": {"y_m": [0.6, 0.7], "z_m": [0.5, 0.6]}}], "task.avoid": [{"y_m": [0.5, 0.8]}]},
            "task.visit[0].box",
            "lies within task.avoid[0]",
        ),
        (
            {"task.goal.x_m": 1.6, "task.avoid": [{"x_m": [1.2, 1.4]}]},
            "task.avoid[0].x_m",
            "a wall between the start and the goal",
        ),
        (
            {"task.goal.z_m": 1.3, "task.avoid": [{"y_m": [-1, 2], "z_m": [1.1, 1.12], "rx_deg": [-31, 31]}]},
            "task.avoid[0].z_m",
            "a wall between",
        ),
    ],
)
def test_what_is_refused(quick_config: Config, vary, values: dict[str, object], key: str, words: str) -> None:
    """Each with its key, and the number that counting gives."""
    found = issues(vary(quick_config, values))
    assert list(found) == [key]
    assert words in found[key]


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"task.budget.mode_changes": 3, "route.step_budget": 5},
        {"task.goal.x_m": 1.6, "task.avoid": [{"x_m": [1.2, 1.4], "y_m": [-0.2, 1.3]}]},
        {"task.goal.x_m": 1.6, "task.avoid": [{"x_m": [1.7, 1.9]}]},
        {"task.goal.x_m": 1.3, "task.budget.travel_m": 0.28, "task.budget.tilt_deg": 0.1},
        {"task.visit": [{"box": {"y_m": [1.1, 4]}}]},
    ],
)
def test_what_counting_cannot_refuse(quick_config: Config, vary, values: dict[str, object]) -> None:
    """Just enough, or a way round."""
    assert issues(vary(quick_config, values)) == {}


def test_everything_is_told_at_once(quick_config: Config, vary, machine: Machine) -> None:
    """Actuators out of range at both ends, and what counting excludes."""
    config = vary(quick_config, {"task.start.x_m": -0.9, "task.goal.x_m": 1.9, "task.budget.mode_changes": 1})
    with pytest.raises(ConfigError) as caught:
        require_possible_task(config, machine)
    told = [issue.path for issue in caught.value.issues]
    assert told.count("task.start") > 1
    assert told.count("task.goal") > 1
    assert told[-2:] == ["task.budget.mode_changes", "route.step_budget"]
    assert {"task.start.x_m", "task.goal.x_m"} <= set(told)


@pytest.fixture(scope="module")
def tiny(quick_config: Config, vary) -> tuple[Config, Route]:
    """Plan a route on a very coarse grid, over a box to visit."""
    values = {
        "route.grid": {
            "y_m": {"min": 0.1, "max": 0.9, "step": 0.2},
            "z_m": {"min": 0.5, "max": 1.1, "step": 0.2},
            "rx_step_deg": 30,
            "rz_step_deg": 30,
        },
        "route.x_step_m": 0.2,
        "task.visit": [{"box": {"y_m": [0.55, 0.75], "x_m": [1.1, 1.2]}}],
    }
    config = vary(quick_config, values)
    machine = build_machine(config.machine)
    return config, plan_route(config, machine, build_regions(config, machine))


@settings(max_examples=50)
@given(
    first=st.integers(0, 50),
    last=st.integers(0, 50),
    visits=st.sets(st.integers(1, 50), max_size=3),
    grown=st.floats(0.0, 0.3),
)
def test_what_a_route_does_is_never_refused(tiny: tuple[Config, Route], vary, first, last, visits, grown) -> None:
    """A task made of a real route, from one of its positions to another over others, with budgets as it uses them."""
    config, route = tiny
    first, last = sorted((first % len(route), last % len(route)))
    if first == last or route.gates[first] or route.gates[last]:
        return

    def at(k: int) -> dict[str, object]:
        x, y, z, rx, _, rz = route.pose[k].tolist()
        tilts = {"rx_deg": float(np.rad2deg(rx)), "rz_deg": float(np.rad2deg(rz))}
        return {"x_m": x, "y_m": y, "z_m": z, **tilts, "mode": route.mode_names[k]}

    def around(k: int) -> dict[str, object]:
        y, z = route.pose[k, 1], route.pose[k, 2]
        return {"box": {"y_m": [y - 0.01 - grown, y + 0.01], "z_m": [z - 0.01, z + 0.01 + grown]}}

    part = np.abs(np.diff(route.pose[first : last + 1], axis=0))
    changes = sum(
        (a ^ b).bit_count()
        for a, b in zip(route.modes[first:last].tolist(), route.modes[first + 1 :].tolist(), strict=False)
    )
    inner = [k for k in sorted(visits) if first < k < last]
    asked = vary(
        config,
        {
            "task.start": at(first),
            "task.goal": at(last),
            "task.visit": [around(k) for k in inner],
            "task.budget.mode_changes": changes,
            "task.budget.travel_m": float(part[:, :3].sum()) + 1e-9,
            "task.budget.tilt_deg": float(np.rad2deg(part[:, [3, 5]].sum())) + 1e-9,
            "route.step_budget": max(last - first + 1, 2),
        },
    )
    assert (part[:, [0, 1, 2, 3, 5]] <= step_sizes(config.route) + 1e-9).all()
    assert counting_issues(asked) == []


@settings(max_examples=40)
@given(x_m=st.floats(-3.0, 4.0), y_m=st.floats(0.0, 0.9), mode=st.sampled_from(["LLL", "RRR"]))
def test_the_x_that_would_do_does(
    quick_config: Config, vary, machine: Machine, x_m: float, y_m: float, mode: str
) -> None:
    """With any x of the interval that is named the carts are on their rails; without one they cannot be."""

    def refused(x: float) -> dict[str, str]:
        place = {"task.start.x_m": x, "task.start.y_m": y_m, "task.start.mode": mode}
        try:
            task_endpoints(vary(quick_config, place), machine)
        except ConfigError as error:
            return {issue.path: issue.message for issue in error.issues if "start" in issue.path}
        return {}

    said = refused(x_m).get("task.start.x_m")
    if said is None or "all carts are on their rails for" not in said:
        return
    least, largest = (float(word) for word in said.rpartition(" for ")[2].split(" to "))
    assert not least <= x_m <= largest
    for x in (least, 0.5 * (least + largest), largest):
        assert "task.start.x_m" not in refused(x)
        assert not any("needs c" in message for message in refused(x).values())
