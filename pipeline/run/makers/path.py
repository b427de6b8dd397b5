"""Make the refined path."""

from typing import TYPE_CHECKING

from pipeline.artifacts.results.path import path_files
from pipeline.progress import Monitor
from pipeline.refine import refine_path
from pipeline.refine.measure import measure_path
from pipeline.refine.result import Refinement
from pipeline.route.metric import step_sizes
from pipeline.run.makers.path_samples import sample_paths
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.path import path_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_path(results: "Results", monitor: Monitor) -> Product:
    """Smooth the route, and measure the path against the route joined by straight lines."""
    config = results.config
    refinement = refine_path(config, results.machine, results.route, monitor)
    monitor.progress(f"measuring both paths at {config.refine.check_points:,} points")
    return path_product(results, refinement)


def path_product(results: "Results", refinement: Refinement) -> Product:
    """Keep both paths, and make their files and summary."""
    results.keep(Stage.REFINE, refinement)
    coarse, refined = results.derive(sample_paths)
    steps = step_sizes(results.config.route)
    section = path_section(refinement, measure_path(refined, steps), measure_path(coarse, steps))
    return Product(path_files(refinement, refined), section)
