"""A path as a file of its own, and the refined path of any run's `path.npz`."""

import pathlib

from pipeline.artifacts.files import write_whole
from pipeline.artifacts.pack import npz_bytes, pack_path, read_npz, readable, unpack_path
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


def save_path(file: pathlib.Path | str, path: Path) -> None:
    """Write degree, knots, coefficients and known poses of a path as an .npz file."""
    write_whole(pathlib.Path(file), npz_bytes(pack_path(path, "")))


def load_path(file: pathlib.Path | str, machine: Machine) -> Path:
    """Load a path for the machine it was made for: what `save_path` wrote, or the `path.npz` of a run.

    Raises
    ------
    UsageError
        When the file cannot be read as a path.
    """
    file = pathlib.Path(file)
    with readable(file):
        return unpack_path(read_npz(file), "", machine)
