from .graph import (
    AtlasGraph as AtlasGraph,
)
from .graph import (
    build_graph as build_graph,
)
from .plan import (
    AtlasEntry as AtlasEntry,
)
from .plan import (
    plan_pairs as plan_pairs,
)
from .record import (
    AtlasRecord as AtlasRecord,
)
from .record import (
    MotionRecord as MotionRecord,
)
from .record import (
    PairRecord as PairRecord,
)
from .record import (
    StationRecord as StationRecord,
)
from .stations import (
    Station as Station,
)
from .stations import (
    atlas_stations as atlas_stations,
)
from .stations import (
    pair_config as pair_config,
)
from .stations import (
    require_stations as require_stations,
)
