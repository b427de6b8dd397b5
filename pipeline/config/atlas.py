"""The atlas: the stations between all of which routes are planned."""

from collections import Counter
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from pipeline.config.section import Section, wrong
from pipeline.config.task import PoseConfig

STATION_PATTERN = r"^\w+([.-]\w+)*$"
_MOST_STATIONS, _MOST_NAME = 100, 40


class StationConfig(Section):
    """A named pose that routes begin and end at, in its working mode."""

    on_one_line: ClassVar[bool] = True

    name: Annotated[str, Field(pattern=STATION_PATTERN, max_length=_MOST_NAME, description="names the station")]
    pose: PoseConfig


class AtlasConfig(Section):
    """The stations of `gantry-tau atlas`; a run does not read them."""

    stations: tuple[StationConfig, ...] = Field(
        (),
        max_length=_MOST_STATIONS,
        description="named poses, at least two: {name: feeder, pose: {x_m: 1.02, y_m: 0.3, z_m: 0.9, mode: LLL}}; "
        "none: start, goal and the poses to visit",
    )

    @model_validator(mode="after")
    def _told_apart(self) -> Self:
        if len(self.stations) == 1:
            raise wrong("stations", "has one entry; allowed are none, or at least two")
        twice = [name for name, count in Counter(station.name for station in self.stations).items() if count > 1]
        if twice:
            raise wrong("stations", f"has {twice[0]} more than once; every station needs a name of its own")
        return self
