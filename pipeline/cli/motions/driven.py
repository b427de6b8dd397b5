"""The motion of a run as it was exported and driven: at a part of the speed, another period, or back."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.errors import UsageError
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.calibrate import DrivenMotion
    from pipeline.config import Config
    from pipeline.retime import Trajectory
    from pipeline.simulate import Motion

DrivenSpeed = Annotated[
    float | None,
    typer.Option(
        "--speed",
        metavar="PART",
        help="Part of the full speed at which it was driven, as exported. Default: full speed.",
    ),
]
DrivenPeriod = Annotated[
    float | None,
    typer.Option("--period", metavar="S", help="Period at which it was driven, as exported. Default: that of the run."),
]
DrivenBack = Annotated[bool, typer.Option("--back", help="The way back, as exported with --back.")]
DrivesOption = Annotated[
    Path | None,
    typer.Option(
        "--drives", metavar="FILE", help="A YAML file whose section drives is used. Default: that of the run."
    ),
]
GeometryOption = Annotated[
    float,
    typer.Option(
        "--geometry", metavar="M", min=0.0, max=0.01, help="Standard deviation of joints, rails, lengths in metres."
    ),
]


def driven(run: Path, speed: float | None, period_s: float | None, back: bool) -> "tuple[Trajectory, Config]":
    """Give the motion of a run as exported at a part of the speed, another period, or back, and its configuration."""
    from pipeline.retime import slowed, way_back, whole_periods
    from pipeline.run.reading import open_results, with_retime

    results = open_results(run, Stage.REFINE, Stage.RETIME)
    config = with_retime(results.config, period_s=period_s, speed=speed)
    there = slowed(results.trajectory, 1.0 if speed is None else config.retime.speed)
    trajectory = way_back(config, there) if back else whole_periods(there, config.retime.period_s)
    return trajectory, config


def driven_motion(
    run: Path | None, speed: float | None, period_s: float | None, back: bool, late_s: float = 0.0
) -> "DrivenMotion | None":
    """Give what encoders showed while a run was driven, in the units of its controller; None without a run.

    Raises
    ------
    UsageError
        When it is said how it was driven, or by how much a clock is late, but not which run.
    """
    if run is None:
        if back or speed is not None or period_s is not None:
            raise UsageError("--speed, --period and --back go with --run RUN: they say how it was driven")
        if late_s != 0.0:
            raise UsageError("--clock goes with --run RUN: poses of a machine that stands still need no clock")
        return None
    from pipeline.calibrate import DrivenMotion
    from pipeline.machine.actuator_space.controller_units import controller_units

    trajectory, config = driven(run, speed, period_s, back)
    return DrivenMotion(trajectory, controller_units(config.machine), config.retime.period_s)


def planned(trajectory: "Trajectory", config: "Config", period_s: float | None) -> "Motion":
    """Plan the set points of the controllers: at a period, or at the one that fits the period of the run."""
    from pipeline.simulate import controller_period, plan_motion

    return plan_motion(trajectory, controller_period(config.retime.period_s) if period_s is None else period_s)


def with_drives(config: "Config", file: Path) -> "Config":
    """Give a configuration with the section `drives` of another file.

    Raises
    ------
    ConfigError
        When there is no such section, or it is not valid.
    """
    from pipeline.config.file import parse_config, read_yaml
    from pipeline.errors import ConfigError, ConfigIssue

    given = read_yaml(file)
    if not isinstance(given, dict) or "drives" not in given:
        raise ConfigError(
            [ConfigIssue("drives", "is missing; expected a section with carts and telescopes")], str(file)
        )
    data = {**config.model_dump(mode="json"), "drives": given["drives"]}
    return config.model_copy(update={"drives": parse_config(data, source=str(file)).drives})
