"""Files put into a folder, and results compared to the last bit."""

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from pipeline.config import Config
from pipeline.machine import Machine


@dataclass
class SavedRun:
    """What loaders have to know of a run."""

    folder: Path
    machine: Machine
    config: Config | None = None


def put(folder: Path, files: dict[str, bytes]) -> None:
    """Write files as they are."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def same(a: object, b: object) -> bool:
    """Compare two results field by field, to the last bit."""
    for item in fields(a):
        left, right = getattr(a, item.name), getattr(b, item.name)
        if isinstance(left, np.ndarray):
            if left.dtype != right.dtype or not np.array_equal(left, right, equal_nan=left.dtype.kind == "f"):
                return False
        elif left != right or type(left) is not type(right):
            return False
    return True
