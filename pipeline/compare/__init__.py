"""Looking at results: the coarse path against the refined one, runs against each other, and pictures."""

from pipeline.compare.blend import TOLERANCE_M, blended
from pipeline.compare.figures import all_figures
from pipeline.compare.figures.maps import KappaMap, kappa_map
from pipeline.compare.metrics import ComparisonRow, compare_paths, markdown_table, table_cells
from pipeline.compare.motion import MotionFigures, common_retiming, measure_motion, retimed
from pipeline.compare.quantities import MeasuredPath
from pipeline.compare.runs import RunsRow, compare_runs, runs_cells, runs_header, runs_markdown
from pipeline.compare.workspace import Workspace, WorkspaceSetting, usable_workspace
from pipeline.compare.workspace_table import WorkspaceRow, workspace_rows

__all__ = [
    "TOLERANCE_M",
    "ComparisonRow",
    "KappaMap",
    "MeasuredPath",
    "MotionFigures",
    "RunsRow",
    "Workspace",
    "WorkspaceRow",
    "WorkspaceSetting",
    "all_figures",
    "blended",
    "common_retiming",
    "compare_paths",
    "compare_runs",
    "kappa_map",
    "markdown_table",
    "measure_motion",
    "retimed",
    "runs_cells",
    "runs_header",
    "runs_markdown",
    "table_cells",
    "usable_workspace",
    "workspace_rows",
]
