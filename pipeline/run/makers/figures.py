"""Make the figures and the report."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import TYPE_CHECKING

from pipeline.artifacts.layout import REPORT
from pipeline.artifacts.state import State, read_state
from pipeline.progress import Monitor
from pipeline.run.makers.pictures import early_pictures, late_pictures
from pipeline.run.makers.report_page import report_page
from pipeline.run.product import Product
from pipeline.summary.figures import figures_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_figures(results: "Results", monitor: Monitor) -> Product:
    """Draw the results, and put the key figures on one page; a second process may have made a part of it."""
    beside = results.beside
    if beside is not None:
        beside.ask()
    monitor.progress("drawing")
    late = late_pictures(results)
    made = None if beside is None else beside.answer()
    if made is None:
        made = early_pictures(results)
        monitor.progress("writing the report")
        made[REPORT] = report_page(results, read_state(results.folder) or State())
    page = made.pop(REPORT)
    return figures_product({**made, **late}, page)


def figures_product(pictures: Mapping[str, bytes], page: bytes) -> Product:
    """Make the files and the summary of the figures and the report."""
    return Product({**pictures, REPORT: page}, figures_section(len({PurePath(name).stem for name in pictures})))
