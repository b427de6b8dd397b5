"""The configuration: one YAML file that describes machine, task and the options of every stage.

Units are part of the key names. Unknown keys are refused; every message names the key's path, the value
found there and what is allowed. `load_config` reads a file; `Config.model_json_schema()` is its schema.
"""

from pipeline.config.certify import CertifyConfig
from pipeline.config.config import Config
from pipeline.config.export import ExportConfig
from pipeline.config.machine import (
    ActuatorLimitsConfig,
    ClearanceConfig,
    DynamicsConfig,
    FixedLinkConfig,
    FrictionConfig,
    LimitsConfig,
    LinksConfig,
    MachineConfig,
    PlatformMassConfig,
    RailConfig,
    TcpLimitsConfig,
    TelescopeConfig,
    TriangleLinkConfig,
)
from pipeline.config.refine import RefineConfig
from pipeline.config.retime import RetimeConfig
from pipeline.config.route import (
    AxisConfig,
    FollowConfig,
    GridConfig,
    RouteConfig,
)
from pipeline.config.section import MODE_PATTERN, NAME_PATTERN, Section
from pipeline.config.task import (
    BoxConfig,
    BudgetConfig,
    PoseConfig,
    TaskConfig,
    VisitConfig,
)

__all__ = [
    "MODE_PATTERN",
    "NAME_PATTERN",
    "ActuatorLimitsConfig",
    "AxisConfig",
    "BoxConfig",
    "BudgetConfig",
    "CertifyConfig",
    "ClearanceConfig",
    "Config",
    "DynamicsConfig",
    "ExportConfig",
    "FixedLinkConfig",
    "FollowConfig",
    "FrictionConfig",
    "GridConfig",
    "LimitsConfig",
    "LinksConfig",
    "MachineConfig",
    "PlatformMassConfig",
    "PoseConfig",
    "RailConfig",
    "RefineConfig",
    "RetimeConfig",
    "RouteConfig",
    "Section",
    "TaskConfig",
    "TcpLimitsConfig",
    "TelescopeConfig",
    "TriangleLinkConfig",
    "VisitConfig",
]
