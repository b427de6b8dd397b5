"""Make the figures and the report."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import TYPE_CHECKING

from pipeline.artifacts.layout import REPORT
from pipeline.artifacts.state import State, read_state
from pipeline.figures import FIGURES, RunFigure
from pipeline.progress import Monitor
from pipeline.run.makers.pictures import picture
from pipeline.run.makers.report_page import report_page
from pipeline.run.product import Product
from pipeline.summary.figures import figures_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_figures(results: "Results", monitor: Monitor) -> Product:
    """Draw the results, and put the key figures on one page, together with the second process if there is one.

    That begins with the first figure and this one with the last; the report is made where its parts are.
    """
    beside, made = results.beside, dict[str, dict[str, bytes]]()

    def announce(figure: RunFigure) -> None:
        number = len(made) + 1
        monitor.progress(f"figure {number} of {len(FIGURES)}, {figure.name}", number / len(FIGURES))

    for figure in reversed(FIGURES):
        if beside is None or beside.take(figure.name):
            announce(figure)
            made[figure.name] = picture(figure, results)
    files = dict[str, bytes]()
    for figure in FIGURES:
        if figure.name not in made:
            announce(figure)
            there = None if beside is None else beside.files(figure.name)
            made[figure.name] = picture(figure, results) if there is None else there
        files |= made[figure.name]
    monitor.progress("writing the report")
    there = None if beside is None else beside.files(REPORT)
    page = report_page(results, read_state(results.folder) or State()) if there is None else there[REPORT]
    return figures_product(files, page)


def figures_product(pictures: Mapping[str, bytes], page: bytes) -> Product:
    """Make the files and the summary of the figures and the report."""
    return Product({**pictures, REPORT: page}, figures_section(len({PurePath(name).stem for name in pictures})))
