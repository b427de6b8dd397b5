"""Looking at results: the coarse path against the refined one, runs against each other, and pictures."""

from pipeline.compare.blend import TOLERANCE_M, blended
from pipeline.compare.figures import all_figures
from pipeline.compare.metrics import ComparisonRow, comparison_rows, markdown_table, table_cells
from pipeline.compare.motion import MotionFigures, common_retiming, measure_motion, retimed
from pipeline.compare.quantities import Measured
from pipeline.compare.runs import RunsRow, runs_cells, runs_header, runs_markdown, runs_rows

__all__ = [
    "TOLERANCE_M",
    "ComparisonRow",
    "Measured",
    "MotionFigures",
    "RunsRow",
    "all_figures",
    "blended",
    "common_retiming",
    "comparison_rows",
    "markdown_table",
    "measure_motion",
    "retimed",
    "runs_cells",
    "runs_header",
    "runs_markdown",
    "runs_rows",
    "table_cells",
]
