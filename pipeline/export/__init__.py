"""Results in the forms other programs read: CSV for controllers, and the sidecar that explains it."""

from pipeline.export.csv import format_csv, read_csv, trajectory_columns
from pipeline.export.sidecar import sidecar

__all__ = ["format_csv", "read_csv", "sidecar", "trajectory_columns"]
