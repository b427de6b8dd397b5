"""Whether a task can be planned at all: everything that is known before any search."""

from pipeline.config import Config
from pipeline.limits.kappa import require_ends_below_cap
from pipeline.machine.geometry import Machine
from pipeline.route.regions.counting import require_possible_task
from pipeline.route.regions.endpoints import Endpoint
from pipeline.route.regions.size import require_table_fits
from pipeline.route.straight_ends import require_straight_ends


def require_sound_task(config: Config, machine: Machine) -> tuple[Endpoint, Endpoint]:
    """Place the machine at start and goal, and require all that can be checked without a search.

    Raises
    ------
    ConfigError
        When the machine cannot be at the start, the goal or a pose to visit, the task is impossible by counting, a
        straight end fails, the table of regions takes more memory than allowed, or refine.kappa_max is too small.
    """
    ends = require_possible_task(config, machine)
    require_straight_ends(config, machine)
    require_table_fits(config, machine)
    require_ends_below_cap(config, [end.kappa for end in ends])
    return ends
