"""Looking at results: the coarse path against the refined one, as a table and as pictures."""

from pipeline.compare.figures import all_figures
from pipeline.compare.metrics import ComparisonRow, comparison_rows, markdown_table, table_cells

__all__ = ["ComparisonRow", "all_figures", "comparison_rows", "markdown_table", "table_cells"]
