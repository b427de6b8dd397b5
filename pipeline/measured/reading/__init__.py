"""Tables of numbers as trackers and spreadsheets write them: read strictly, with an account of every line.

Lines are split by `csv` of the standard library, strictly and one at a time. Readers of whole tables (pandas, polars)
let a quoted value go on in the next line, so that two stray quotes drop all rows in between without a word, and they
fill short rows; the strict engine of pandas is the same `csv`.
"""

from pipeline.measured.reading.account import Account, Skipped
from pipeline.measured.reading.header import match_columns
from pipeline.measured.reading.table import Table, read_table

__all__ = ["Account", "Skipped", "Table", "match_columns", "read_table"]
