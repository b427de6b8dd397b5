"""Comparisons: the coarse path with the refined one, and runs with each other."""

from pipeline.compare.blend import TOLERANCE_M, blended
from pipeline.compare.criteria import MeasuredPath
from pipeline.compare.metrics import ComparisonRow, compare_paths, markdown_table, table_cells
from pipeline.compare.motion import MotionFigures, common_retiming, measure_motion, retimed
from pipeline.compare.runs import RunsRow, compare_runs, runs_cells, runs_header, runs_markdown

__all__ = [
    "TOLERANCE_M",
    "ComparisonRow",
    "MeasuredPath",
    "MotionFigures",
    "RunsRow",
    "blended",
    "common_retiming",
    "compare_paths",
    "compare_runs",
    "markdown_table",
    "measure_motion",
    "retimed",
    "runs_cells",
    "runs_header",
    "runs_markdown",
    "table_cells",
]
