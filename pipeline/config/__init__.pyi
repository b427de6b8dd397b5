from .atlas import (
    AtlasConfig as AtlasConfig,
)
from .atlas import (
    StationConfig as StationConfig,
)
from .config import (
    Config as Config,
)
from .drives import (
    DrivesConfig as DrivesConfig,
)
from .export import (
    ExportConfig as ExportConfig,
)
from .machine.bodies import (
    BodyConfig as BodyConfig,
)
from .machine.bodies import (
    ObstacleConfig as ObstacleConfig,
)
from .machine.limits import (
    ActuatorLimitsConfig as ActuatorLimitsConfig,
)
from .machine.limits import (
    LimitsConfig as LimitsConfig,
)
from .machine.limits import (
    TcpLimitsConfig as TcpLimitsConfig,
)
from .machine.links import (
    ClearanceConfig as ClearanceConfig,
)
from .machine.links import (
    FixedLinkConfig as FixedLinkConfig,
)
from .machine.links import (
    LinksConfig as LinksConfig,
)
from .machine.links import (
    RailConfig as RailConfig,
)
from .machine.links import (
    TelescopeConfig as TelescopeConfig,
)
from .machine.links import (
    TriangleLinkConfig as TriangleLinkConfig,
)
from .machine.machine import (
    MachineConfig as MachineConfig,
)
from .machine.masses import (
    DynamicsConfig as DynamicsConfig,
)
from .machine.masses import (
    FrictionConfig as FrictionConfig,
)
from .machine.masses import (
    PlatformMassConfig as PlatformMassConfig,
)
from .section import (
    MODE_PATTERN as MODE_PATTERN,
)
from .section import (
    NAME_PATTERN as NAME_PATTERN,
)
from .section import (
    Section as Section,
)
from .stages.certify import (
    CertifyConfig as CertifyConfig,
)
from .stages.figures import (
    FiguresConfig as FiguresConfig,
)
from .stages.refine import (
    RefineConfig as RefineConfig,
)
from .stages.retime import (
    RetimeConfig as RetimeConfig,
)
from .stages.route import (
    AxisConfig as AxisConfig,
)
from .stages.route import (
    FollowConfig as FollowConfig,
)
from .stages.route import (
    GridConfig as GridConfig,
)
from .stages.route import (
    RouteConfig as RouteConfig,
)
from .task import (
    BoxConfig as BoxConfig,
)
from .task import (
    BudgetConfig as BudgetConfig,
)
from .task import (
    PoseConfig as PoseConfig,
)
from .task import (
    TaskConfig as TaskConfig,
)
from .task import (
    VisitConfig as VisitConfig,
)
