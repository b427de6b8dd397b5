"""Make the region table."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from pipeline.artifacts.region_cache import keep_grid, load_grid
from pipeline.artifacts.results.regions import regions_files
from pipeline.progress import Monitor
from pipeline.route import build_regions, grid_regions
from pipeline.route.regions.table import RegionTable
from pipeline.run.fingerprint import grid_fingerprint
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.regions import regions_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_regions(results: "Results", monitor: Monitor) -> Product:
    """Find every admissible region of the grid, and add those the task needs."""
    grid = cached_grid(results, monitor, lambda: grid_regions(results.config, results.machine, monitor))
    return regions_product(results, build_regions(results.config, results.machine, monitor, grid))


def regions_product(results: "Results", table: RegionTable) -> Product:
    """Keep the region table, and make its files and summary."""
    results.keep(Stage.REGIONS, table)
    return Product(regions_files(table), regions_section(results.config, table))


def cached_grid(results: "Results", monitor: Monitor, compute: Callable[[], RegionTable]) -> RegionTable:
    """Take the regions of grid and gates from an earlier run beside this one, or compute and cache them."""
    runs, key = results.folder.parent, grid_fingerprint(results.config)
    known = None if results.recompute else load_grid(runs, key)
    if known is not None:
        monitor.progress("regions: grid and gates known from an earlier run", 1.0)
        return known
    grid = compute()
    keep_grid(runs, key, grid)
    return grid
