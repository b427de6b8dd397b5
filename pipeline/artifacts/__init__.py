"""Result files: the only package that knows their names, how they are written, and how they are loaded back."""

from pipeline.artifacts.files import json_bytes, jsonable, sha256, write_whole
from pipeline.artifacts.folder import RunFolder, open_run_folder, read_run_folder
from pipeline.artifacts.layout import existing_files
from pipeline.artifacts.state import Record, State, read_state

__all__ = [
    "Record",
    "RunFolder",
    "State",
    "existing_files",
    "json_bytes",
    "jsonable",
    "open_run_folder",
    "read_run_folder",
    "read_state",
    "sha256",
    "write_whole",
]
