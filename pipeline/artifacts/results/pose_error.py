"""The proven error of the tool as a file."""

import pathlib

from pipeline.artifacts.files import naming
from pipeline.artifacts.layout import POSE_ERROR_CSV
from pipeline.artifacts.npz import readable
from pipeline.artifacts.results.saved import SavedRun
from pipeline.config.stages.pose_error import PoseErrorConfig
from pipeline.export.csv import format_csv, read_csv
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.pose_error import PoseError, pose_error_columns, pose_error_of


def pose_error_files(found: PoseError) -> dict[str, bytes]:
    """Write the bounds over s."""
    return {POSE_ERROR_CSV: format_csv(pose_error_columns(found)).encode()}


def uncertainty_of(config: PoseErrorConfig) -> Uncertainty:
    """Give the errors that the configuration has."""
    return Uncertainty(config.lengths_m, config.coordinates_m, config.drives_m)


def load_pose_error(run: SavedRun) -> PoseError | None:
    """Load the bounds of a run; None if its configuration asks for none.

    Raises
    ------
    UsageError
        When the file is damaged.
    """
    config = run.config.certify.pose_error
    if config is None:
        return None
    file: pathlib.Path = run.folder / POSE_ERROR_CSV
    with naming(file), readable(file):
        return pose_error_of(uncertainty_of(config), read_csv(file.read_text()))
