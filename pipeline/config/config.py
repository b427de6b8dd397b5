"""The whole configuration: machine, task, and the options of every stage."""

from pydantic import Field

from pipeline.config.certify import CertifyConfig
from pipeline.config.export import ExportConfig
from pipeline.config.machine import MachineConfig
from pipeline.config.refine import RefineConfig
from pipeline.config.retime import RetimeConfig
from pipeline.config.route import RouteConfig
from pipeline.config.section import MOST_NAME, NAME_PATTERN, Section
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
    export: ExportConfig = Field(default_factory=lambda: ExportConfig())
