"""How a stage reports what it is doing, without knowing who listens."""

from dataclasses import dataclass
from typing import Protocol


class Progress(Protocol):
    """Receives progress messages; the command line turns them into a progress line."""

    def __call__(self, message: str, fraction: float | None = None) -> None:
        """Report the current activity and, if known, the fraction done (0 to 1)."""


def silent(message: str, fraction: float | None = None) -> None:
    """Ignore all progress messages."""


@dataclass(frozen=True)
class Monitor:
    """How a stage is watched.

    Attributes
    ----------
    progress : Progress
        Receives progress messages.
    verbose : bool
        Solvers write their logs to the terminal.
    """

    progress: Progress = silent
    verbose: bool = False


QUIET = Monitor()
"""No progress messages and no solver logs: the default."""
