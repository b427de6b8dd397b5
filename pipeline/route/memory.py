"""What stage one takes up in memory, counted before it is allocated, against `route.memory_gb`.

Bytes per grid point, region and move are measured at their peak, beside the 0.1 to 0.2 GB of the program itself.
"""

from pipeline.config import RouteConfig
from pipeline.errors import NoSolutionError

POINT_BYTES = 220
"""A grid point: its row of the grid, and the discriminants on three sides of cart 3 with their signs along edges."""
ROW_BYTES = 320
"""A region while tables are put together: a row of 152 bytes, twice, and the rows picked."""
_REGION_BYTES = 640
"""A row of the table, twice while it is put together, its share of the search and of the shortest paths."""
_MOVE_BYTES = 32
"""A move is a pair of 4 bytes each; the graph adds its cost, 8, and the reversed graph 12."""
_GB = 1e9


def memory_gb(regions: float, moves: float) -> float:
    """Estimate the memory that a region table, its moves and the shortest paths over them take up at their peak."""
    return (regions * _REGION_BYTES + moves * _MOVE_BYTES) / _GB


def require_memory(options: RouteConfig, needed_bytes: float, what: str, advice: str, **facts: object) -> None:
    """Refuse what takes up more than is allowed, before it is allocated.

    Parameters
    ----------
    needed_bytes : float
        Memory at the peak.
    what : str
        What takes it up, with its numbers.
    advice : str
        What else could be changed, beside allowing more.
    facts
        For the diagnosis.

    Raises
    ------
    NoSolutionError
        When it is more than `route.memory_gb`.
    """
    needed, allowed = needed_bytes / _GB, options.memory_gb
    if needed > allowed:
        raise NoSolutionError(
            "route",
            f"{what} would take up {needed:,.2f} GB of memory; route.memory_gb allows {allowed:g}",
            f"set route.memory_gb to {1.1 * needed:,.2f} where there is as much, or {advice}",
            {**facts, "expected_memory_gb": needed},
        )
