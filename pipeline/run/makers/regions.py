"""Make the region table."""

from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.artifacts.results.regions import regions_files
from pipeline.progress import Monitor
from pipeline.route import build_regions, grid_regions
from pipeline.route.regions.size import require_table_fits
from pipeline.route.regions.table import RegionTable
from pipeline.run.makers.grid_cache import cached_grid
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.regions import regions_section
from pipeline.summary.workspace import workspace_part
from pipeline.workspace.installation import measure_space

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_regions(results: "Results", monitor: Monitor) -> Product:
    """Find every admissible region of the grid, and add those the task needs."""
    return _with_workspace(results, _found(results, monitor))


def _found(results: "Results", monitor: Monitor) -> Product:
    if Stage.REGIONS in results.given:
        return regions_product(results, results.given[Stage.REGIONS]())
    require_table_fits(results.config, results.machine)
    grid = cached_grid(results, monitor, lambda: grid_regions(results.config, results.machine, monitor))
    return regions_product(results, build_regions(results.config, results.machine, monitor, grid))


def _with_workspace(results: "Results", product: Product) -> Product:
    """Add what the machine can use of the space that it takes up: it is measured in a moment."""
    return replace(product, section={**product.section, **workspace_part(measure_space(results.machine))})


def regions_product(results: "Results", table: RegionTable) -> Product:
    """Keep the region table, and make its files and summary."""
    results.keep(Stage.REGIONS, table)
    return Product(regions_files(table), regions_section(results.config, table))
