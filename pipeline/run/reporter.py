"""How a run tells what it is doing, without knowing who listens."""

from typing import Protocol

from pipeline.progress import Progress, silent
from pipeline.stage import Stage


class Reporter(Protocol):
    """Told when a stage begins and ends."""

    def begin(self, stage: Stage) -> Progress:
        """A stage starts working; what it has to say while it does goes to the function returned."""

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        """Take note of a stage that is "done", "failed", or "unchanged" and was not run."""


class Quiet:
    """Listens to nothing: the default."""

    def begin(self, stage: Stage) -> Progress:
        """Give the stage nobody to talk to."""
        return silent

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        """Take no note."""
