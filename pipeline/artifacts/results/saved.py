"""What a loader has to know of a run."""

import pathlib
from typing import Protocol

from pipeline.config import Config
from pipeline.machine.geometry import Machine


class SavedRun(Protocol):
    """A run folder, and the configuration and machine its results were made for."""

    folder: pathlib.Path
    config: Config
    machine: Machine
