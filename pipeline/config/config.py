"""The whole configuration: machine, task, and the options of every stage."""

from collections.abc import Iterator
from typing import Any, Self

from pydantic import Field, ValidationInfo, model_validator

from pipeline.config.atlas import AtlasConfig
from pipeline.config.drives import DrivesConfig
from pipeline.config.export import ExportConfig
from pipeline.config.machine.bodies import require_known, require_names, with_tool
from pipeline.config.machine.links import OF_BODIES
from pipeline.config.machine.machine import MachineConfig
from pipeline.config.section import MOST_NAME, NAME_PATTERN, Section, wrong
from pipeline.config.stages.certify import CertifyConfig
from pipeline.config.stages.figures import FiguresConfig
from pipeline.config.stages.refine import RefineConfig
from pipeline.config.stages.retime import RetimeConfig
from pipeline.config.stages.route import RouteConfig
from pipeline.config.task import TaskConfig


class Config(Section):
    """The whole configuration of one run."""

    name: str = Field(
        "", pattern=NAME_PATTERN, max_length=MOST_NAME, description="name of the run; default: the file's name"
    )
    machine: MachineConfig
    task: TaskConfig
    route: RouteConfig
    refine: RefineConfig = Field(default_factory=lambda: RefineConfig())
    certify: CertifyConfig = Field(default_factory=lambda: CertifyConfig())
    retime: RetimeConfig = Field(default_factory=lambda: RetimeConfig())
    figures: FiguresConfig = Field(default_factory=lambda: FiguresConfig())
    export: ExportConfig = Field(default_factory=lambda: ExportConfig())
    drives: DrivesConfig = Field(default_factory=lambda: DrivesConfig())
    atlas: AtlasConfig = Field(default_factory=lambda: AtlasConfig())

    @model_validator(mode="before")
    @classmethod
    def _equipped(cls, data: Any, info: ValidationInfo) -> Any:
        return with_tool(data, info)

    @model_validator(mode="after")
    def _stations_within_tilt(self) -> Self:
        for k, station in enumerate(self.atlas.stations):
            if fault := self.task.tilt_fault(f"atlas.stations[{k}].pose", station.pose):
                raise fault
        return self

    @model_validator(mode="after")
    def _bodies_are_told_apart(self) -> Self:
        machine, obstacles = self.machine, self.task.obstacles
        unused = sorted(OF_BODIES & machine.clearance.model_dump().keys())
        if unused and not (machine.bodies or machine.link_bodies or obstacles):
            raise wrong(
                f"machine.clearance.{unused[0]}",
                "is of bodies, and there are none: leave it out, or give machine.bodies",
            )
        require_names("task.obstacles", [*machine.bodies, *obstacles])
        require_known("machine.clearance.ignore", machine.clearance.ignore, [*machine.bodies, *obstacles])
        return self

    @model_validator(mode="after")
    def _margins_leave_room(self) -> Self:
        for key, margin, where, (least, largest) in self._margins():
            if 2.0 * margin >= largest - least:
                raise wrong(
                    f"refine.{key}",
                    f"is {margin:g}, which leaves nothing of machine.{where} [{least:g}, {largest:g}]; "
                    f"allowed is less than {(largest - least) / 2.0:g}",
                )
        return self

    def _margins(self) -> Iterator[tuple[str, float, str, tuple[float, float]]]:
        """Give the margin at the ends of every actuator's range: its key and value, the key of the range, the range."""
        for k, rail in enumerate(self.machine.rails):
            yield "travel_margin_m", self.refine.travel_margin_m, f"rails[{k}].travel_m", rail.travel_m
        for name in ("l2b", "l3b"):
            stroke = getattr(self.machine.links, name).stroke_m
            yield "stroke_margin_m", self.refine.stroke_margin_m, f"links.{name}.stroke_m", stroke
