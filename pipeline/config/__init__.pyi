from .certify import (
    CertifyConfig as CertifyConfig,
)
from .config import (
    Config as Config,
)
from .export import (
    ExportConfig as ExportConfig,
)
from .machine import (
    ActuatorLimitsConfig as ActuatorLimitsConfig,
)
from .machine import (
    ClearanceConfig as ClearanceConfig,
)
from .machine import (
    DynamicsConfig as DynamicsConfig,
)
from .machine import (
    FixedLinkConfig as FixedLinkConfig,
)
from .machine import (
    FrictionConfig as FrictionConfig,
)
from .machine import (
    LimitsConfig as LimitsConfig,
)
from .machine import (
    LinksConfig as LinksConfig,
)
from .machine import (
    MachineConfig as MachineConfig,
)
from .machine import (
    PlatformMassConfig as PlatformMassConfig,
)
from .machine import (
    RailConfig as RailConfig,
)
from .machine import (
    TcpLimitsConfig as TcpLimitsConfig,
)
from .machine import (
    TelescopeConfig as TelescopeConfig,
)
from .machine import (
    TriangleLinkConfig as TriangleLinkConfig,
)
from .refine import (
    RefineConfig as RefineConfig,
)
from .retime import (
    RetimeConfig as RetimeConfig,
)
from .route import (
    AxisConfig as AxisConfig,
)
from .route import (
    FollowConfig as FollowConfig,
)
from .route import (
    GridConfig as GridConfig,
)
from .route import (
    RouteConfig as RouteConfig,
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
