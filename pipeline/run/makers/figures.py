"""Make the figures and the report."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pipeline.artifacts.layout import REPORT
from pipeline.artifacts.results.figures import figure_files
from pipeline.artifacts.state import State, read_state
from pipeline.figures import RunData, all_figures
from pipeline.progress import Monitor
from pipeline.retime import sample_trajectory
from pipeline.run.makers.path_samples import sample_paths
from pipeline.run.makers.proven_profile import proven_profile
from pipeline.run.makers.report_page import report_page
from pipeline.run.product import Product
from pipeline.summary.figures import figures_section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.run.results import Results


def make_figures(results: "Results", monitor: Monitor) -> Product:
    """Draw the results, and put the key figures on one page."""
    monitor.progress("drawing")
    coarse, refined = results.derive(sample_paths)
    samples = sample_trajectory(results.trajectory, results.config.retime.period_s)
    figures = all_figures(
        RunData(
            results.config,
            results.machine,
            results.route,
            regions=results.regions,
            coarse=coarse,
            refined=refined,
            kappa_profile=results.derive(proven_profile),
            trajectory=results.trajectory,
            trajectory_samples=samples,
        )
    )
    monitor.progress("writing the report")
    page = report_page(results, read_state(results.folder) or State())
    return figures_product(figures, page, results.config.figures.pdf)


def figures_product(figures: "Mapping[str, Figure]", page: bytes, pdf: bool) -> Product:
    """Make the files and the summary of the figures and the report."""
    return Product({**figure_files(figures, pdf), REPORT: page}, figures_section(len(figures)))
