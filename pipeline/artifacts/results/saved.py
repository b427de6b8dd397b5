"""What a loader has to know of a run."""

import pathlib
from typing import Protocol

from pipeline.machine.geometry import Machine


class SavedRun(Protocol):
    """A run folder, and the machine its results were made for."""

    folder: pathlib.Path
    machine: Machine
