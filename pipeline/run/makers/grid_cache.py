"""Regions of grid and gates, shared by all runs in the same folder."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from pipeline.artifacts.region_cache import keep_grid, load_grid
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.progress import Monitor
from pipeline.route.regions.table import RegionTable
from pipeline.run.config_parts import grid_part
from pipeline.run.stage_specs import SPECS, code_roots
from pipeline.run.up_to_date.source_code import code_sha256
from pipeline.stage import Stage
from pipeline.summary.versions import package_version

if TYPE_CHECKING:
    from pipeline.run.results import Results


def cached_grid(results: "Results", monitor: Monitor, compute: Callable[[], RegionTable]) -> RegionTable:
    """Take the regions of grid and gates from an earlier run beside this one, or compute and cache them."""
    runs, key = results.folder.parent, grid_fingerprint(results.config)
    known = None if results.recompute else load_grid(runs, key, 1e9 * results.config.route.memory_gb)
    if known is not None:
        monitor.progress("regions: grid and gates known from an earlier run", 1.0)
        return known
    grid = compute()
    keep_grid(runs, key, grid)
    return grid


def grid_fingerprint(config: Config) -> str:
    """Hash everything that the regions of grid and gates depend on: not start, goal, name and limits of motion."""
    return config_sha256(
        {
            **grid_part(config),
            "version": package_version(),
            "code": code_sha256(code_roots(SPECS, Stage.REGIONS)),
        }
    )
