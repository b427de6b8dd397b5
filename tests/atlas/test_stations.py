"""Where the stations of an atlas come from, and the task between two of them."""

import pytest

from pipeline.atlas import atlas_stations, pair_config, require_stations
from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.machine import Machine

LOW = {"x_m": 1.02, "y_m": 0.45, "z_m": 0.6, "mode": "LLL"}
FAR = {"x_m": 3.0, "y_m": 0.45, "z_m": 0.6, "mode": "LLL"}


def test_without_a_list_the_task_has_the_stations(quick_config: Config, vary) -> None:
    """Start, goal, and the poses to visit by their numbers; boxes to visit are no poses."""
    box = {"box": {"y_m": [0.1, 0.2]}}
    config = vary(quick_config, {"task.visit": [box, {"pose": LOW}]})
    stations = atlas_stations(config)
    assert [station.name for station in stations] == ["start", "goal", "visit-2"]
    assert [station.key for station in stations] == ["task.start", "task.goal", "task.visit[1].pose"]
    assert stations[2].pose == config.task.visit[1].pose


def test_a_list_takes_their_place(quick_config: Config, vary) -> None:
    """The start and the goal of the task are then no stations."""
    config = vary(quick_config, {"atlas.stations": [{"name": "a", "pose": LOW}, {"name": "b", "pose": FAR}]})
    assert [station.name for station in atlas_stations(config)] == ["a", "b"]


def test_the_task_of_a_pair_has_no_visits(quick_config: Config, vary) -> None:
    """All else stays as it is, and has the names of the stations."""
    config = vary(quick_config, {"task.visit": [{"pose": LOW}], "task.budget.tilt_deg": 90.0})
    _, goal, visit = atlas_stations(config)
    pair = pair_config(config, goal, visit)
    assert (pair.task.start, pair.task.goal, pair.task.visit) == (config.task.goal, visit.pose, ())
    assert (pair.name, pair.task.budget, pair.route) == ("goal--visit-1", config.task.budget, config.route)


def test_every_station_out_of_reach_is_named(quick_config: Config, machine: Machine, vary) -> None:
    """The key says where it is, the message what is wrong."""
    names = [{"name": "a", "pose": FAR}, {"name": "b", "pose": LOW}, {"name": "c", "pose": FAR}]
    config = vary(quick_config, {"atlas.stations": names})
    with pytest.raises(ConfigError) as caught:
        require_stations(config, machine, atlas_stations(config))
    assert {issue.path.removesuffix(".x_m") for issue in caught.value.issues} == {
        "atlas.stations[0].pose",
        "atlas.stations[2].pose",
    }
