"""Result files: the only place that knows their names, how they are written, and what they load back to."""

from pipeline.artifacts.files import json_bytes, plain, sha256, write_whole
from pipeline.artifacts.folder import RunFolder, open_run_folder, read_run_folder
from pipeline.artifacts.layout import existing_files, failure_names, failure_picture, sights
from pipeline.artifacts.state import Record, State, read_state

__all__ = [
    "Record",
    "RunFolder",
    "State",
    "existing_files",
    "failure_names",
    "failure_picture",
    "json_bytes",
    "open_run_folder",
    "plain",
    "read_run_folder",
    "read_state",
    "sha256",
    "sights",
    "write_whole",
]
