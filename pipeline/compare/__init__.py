"""Looking at results: the coarse path against the refined one, runs against each other, and pictures."""

from pipeline.compare.blend import TOLERANCE_M, blended
from pipeline.compare.figures import all_figures
from pipeline.compare.metrics import ComparisonRow, compare_paths, markdown_table, table_cells
from pipeline.compare.motion import MotionFigures, common_retiming, measure_motion, retimed
from pipeline.compare.quantities import Measured, measure_path
from pipeline.compare.runs import RunsRow, compare_runs, runs_cells, runs_header, runs_markdown

__all__ = [
    "TOLERANCE_M",
    "ComparisonRow",
    "Measured",
    "MotionFigures",
    "RunsRow",
    "all_figures",
    "blended",
    "common_retiming",
    "compare_paths",
    "compare_runs",
    "markdown_table",
    "measure_motion",
    "measure_path",
    "retimed",
    "runs_cells",
    "runs_header",
    "runs_markdown",
    "table_cells",
]
