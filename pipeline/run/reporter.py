"""How a run reports what it is doing, without knowing who listens."""

from typing import Protocol

from pipeline.progress import Progress, silent
from pipeline.stage import Stage


class Reporter(Protocol):
    """Is notified when stages begin and end."""

    def begin(self, stage: Stage) -> Progress:
        """Note that a stage begins; the function returned receives its progress messages."""

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        """Note that a stage is "done" or "failed", or "unchanged" and was not run."""


class Quiet:
    """Reports nothing: the default."""

    def begin(self, stage: Stage) -> Progress:
        """Ignore the progress messages."""
        return silent

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        """Ignore the outcome."""
