"""How a stage tells what it is doing, without knowing who listens."""

from typing import Protocol


class Progress(Protocol):
    """Called by a stage as it goes along; the command line turns it into a progress line."""

    def __call__(self, message: str, fraction: float | None = None) -> None:
        """Report what is going on and, where it is known, the fraction done (0 to 1)."""


def silent(message: str, fraction: float | None = None) -> None:
    """Listen to nothing: the default."""
