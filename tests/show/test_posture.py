"""A jogged machine: it stands where it can be, and is refused in the words of `check`."""

import numpy as np
import pytest

from pipeline.config import Config, PoseConfig
from pipeline.config.file import parse_config
from pipeline.errors import ConfigError
from pipeline.machine import Machine, build_machine
from pipeline.route.checked_task import require_sound_task
from pipeline.show.posture import first_posture, in_reach, modes_in_reach, place_machine

REFUSED = [
    {"x_m": 0.9},
    {"rx_deg": 31.0},
    {"z_m": 0.2},
    {"y_m": 1.2},
    {"mode": "RRL"},
    {"rz_deg": -20.0, "y_m": 0.1},
]


def test_the_start_is_within_all_limits(quick_config: Config, machine: Machine) -> None:
    """The first posture is the start of the task, with nothing against it; the nearest limit has the least room."""
    posture = first_posture(quick_config, machine)
    assert posture.asked == quick_config.task.start
    assert posture.reached
    assert posture.refusals == ()
    assert posture.nearest.room == min(one.room for one in posture.readings)
    assert posture.sides == (-1.0, -1.0, -1.0)


@pytest.mark.parametrize("change", REFUSED, ids=str)
def test_refusals_are_those_of_check(quick_config: Config, machine: Machine, change: dict[str, object]) -> None:
    """What is said of a pose is what `check` says of it as the start, word by word, without the key of the start."""
    first = first_posture(quick_config, machine)
    pose = PoseConfig(**{**first.asked.model_dump(), **change})
    posture = place_machine(quick_config, machine, pose, first.samples)
    data = quick_config.model_dump(mode="json")
    data["task"]["start"] = pose.model_dump(mode="json")
    with pytest.raises(ConfigError) as refused:
        require_sound_task(parse_config(data), machine)
    said = [str(issue) for issue in refused.value.issues if issue.path.startswith("task.start")]
    assert said
    for text in said:
        key, message = text.split(": ", 1)
        part = key.removeprefix("task.start").lstrip(".")
        assert f"{part} {message}".strip() in posture.refusals


def test_out_of_reach_it_stays(quick_config: Config, machine: Machine) -> None:
    """The machine keeps its last pose, and what is shown of limits is that of this pose."""
    first = first_posture(quick_config, machine)
    posture = place_machine(quick_config, machine, first.asked.model_copy(update={"y_m": 3.0}), first.samples)
    assert not posture.reached
    assert "is out of reach" in posture.refusals[0]
    assert posture.samples is first.samples
    assert posture.readings == first.readings


def test_modes_in_reach(quick_config: Config, machine: Machine) -> None:
    """Each has kappa and the sign of det H of the machine placed in it."""
    pose = quick_config.task.start
    found = modes_in_reach(machine, pose)
    assert set(found) >= {"LLL", "RRR"}
    for mode, (kappa, sign) in found.items():
        samples = in_reach(machine, pose.model_copy(update={"mode": mode}))
        assert samples is not None
        np.testing.assert_allclose([kappa, sign], [samples.kappa[0], samples.det_sign[0]])


def test_another_machine_begins_where_it_can(quick_config: Config, vary) -> None:
    """Where neither start nor goal is in reach, a pose of the grid is taken; where none is, that is said."""
    moved = vary(quick_config, {"machine.rails.0.y_m": -0.9, "machine.rails.2.y_m": -0.9, "machine.rails.1.y_m": -0.15})
    assert first_posture(moved, build_machine(moved.machine)).reached
    apart = vary(quick_config, {"machine.rails.0.y_m": -6.0})
    with pytest.raises(ConfigError, match="machine: reaches no pose"):
        first_posture(apart, build_machine(apart.machine))
