"""How a run reports what it is doing, without knowing who listens."""

from typing import Protocol

from pipeline.errors import ConfigError, NoSolutionError
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


class NamedReporter:
    """Passes on what the stages of one run of many report, with its name."""

    def __init__(self, name: str, progress: Progress) -> None:
        self._name = name
        self._progress = progress

    def begin(self, stage: Stage) -> Progress:
        """Note that a stage begins."""

        def progress(message: str, fraction: float | None = None) -> None:
            self._progress(f"{self._name}: {stage}: {message.removeprefix(f'{stage}: ')}", fraction)

        progress("started")
        return progress

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        """Ignore the outcome: the record has it."""


def failure_of(error: ConfigError | NoSolutionError) -> tuple[str, str, str]:
    """Say at which stage, why, and what to change."""
    if isinstance(error, NoSolutionError):
        return error.stage, error.reason, error.advice
    return "", "; ".join(str(issue) for issue in error.issues), ""
