"""The stations of an atlas: named poses, and the configuration of the route from one of them to another."""

from dataclasses import dataclass

from pipeline.config import AtlasConfig, Config, PoseConfig
from pipeline.config.section import MOST_NAME
from pipeline.errors import ConfigError, ConfigIssue
from pipeline.machine.geometry import Machine
from pipeline.route.regions.endpoints import place_pose


@dataclass(frozen=True)
class Station:
    """A pose that routes begin and end at; `key` is where it is in the configuration."""

    name: str
    pose: PoseConfig
    key: str


def atlas_stations(config: Config) -> tuple[Station, ...]:
    """List the stations of `atlas.stations`, or else the task's own: start, goal and the poses to visit."""
    if config.atlas.stations:
        return tuple(
            Station(station.name, station.pose, f"atlas.stations[{k}].pose")
            for k, station in enumerate(config.atlas.stations)
        )
    task = config.task
    ends = [Station("start", task.start, "task.start"), Station("goal", task.goal, "task.goal")]
    visits = [
        Station(f"visit-{k + 1}", visit.pose, f"task.visit[{k}].pose")
        for k, visit in enumerate(task.visit)
        if visit.pose is not None
    ]
    return (*ends, *visits)


def require_stations(config: Config, machine: Machine, stations: tuple[Station, ...]) -> None:
    """Require that the machine can be at every station.

    Raises
    ------
    ConfigError
        When it cannot; names every station, and why.
    """
    issues: list[ConfigIssue] = []
    for station in stations:
        _, found = place_pose(config, machine, station.key, station.pose)
        issues += found
    if issues:
        raise ConfigError(issues)


def pair_config(config: Config, origin: Station, target: Station) -> Config:
    """Give the configuration of the task from one station to another: nothing is visited on the way."""
    task = config.task.model_copy(update={"start": origin.pose, "goal": target.pose, "visit": ()})
    name = f"{origin.name}--{target.name}"[:MOST_NAME]
    return config.model_copy(update={"name": name, "task": task, "atlas": AtlasConfig()})
