"""Progress of a run on stderr: a live line on a terminal, occasional plain lines elsewhere."""

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Column

from pipeline.progress import Progress as ProgressFunction
from pipeline.stage import STAGES

_EVERY_S = 5.0
"""Least time between two plain lines of a stage."""
_WIDTH = max(len(stage) for stage in STAGES)


def _without_stage(message: str, stage: str) -> str:
    """Remove the name of the stage from a message: the line already has it."""
    return message.removeprefix(f"{stage}: ")


class PlainReporter:
    """Lines for logs and pipes, and for terminals that solvers also write to."""

    def __init__(self, console: Console) -> None:
        self._console = console

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def begin(self, stage: str) -> ProgressFunction:
        """Report that a stage begins; later messages appear if the last one is old enough."""
        self._console.print(f"{stage}: started", soft_wrap=True)
        said = time.monotonic()

        def progress(message: str, fraction: float | None = None) -> None:
            nonlocal said
            if time.monotonic() - said >= _EVERY_S:
                said = time.monotonic()
                done = "" if fraction is None else f" ({fraction:.0%})"
                self._console.print(f"{stage}: {_without_stage(message, stage)}{done}", soft_wrap=True)

        return progress

    def end(self, stage: str, outcome: str, seconds: float) -> None:
        """Report how a stage ended."""
        took = "" if outcome == "unchanged" else f" ({seconds:.1f} s)"
        self._console.print(f"{stage}: {outcome}{took}", soft_wrap=True)


class LiveReporter:
    """A live line with stage, activity, progress and time; finished stages stay above it."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Progress(
            SpinnerColumn("dots" if console.encoding.startswith("utf") else "line"),
            TextColumn("{task.fields[stage]}", markup=False),
            BarColumn(bar_width=24),
            TimeElapsedColumn(),
            TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1)),
            console=console,
            transient=True,
            refresh_per_second=5,
            expand=True,
        )
        self._task: TaskID | None = None

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._live.stop()

    def begin(self, stage: str) -> ProgressFunction:
        """Show a stage as running."""
        self._task = self._live.add_task("", total=None, stage=f"{stage:<{_WIDTH}}")
        task = self._live.tasks[-1]

        def progress(message: str, fraction: float | None = None) -> None:
            # Without a total the bar pulses: the stage does not know its progress.
            task.total = None if fraction is None else 1.0
            self._live.update(task.id, description=_without_stage(message, stage), completed=fraction or 0.0)

        return progress

    def end(self, stage: str, outcome: str, seconds: float) -> None:
        """Leave a line for a stage that ended."""
        if self._task is not None:
            self._live.remove_task(self._task)
            self._task = None
        took = "" if outcome == "unchanged" else f"{seconds:8.1f} s"
        self._console.print(f"  {stage:<{_WIDTH}} {outcome:<9} {took}")


def make_reporter(console: Console, verbose: bool) -> PlainReporter | LiveReporter:
    """Choose how to show progress: live on terminals that can do that, unless solvers write their logs there."""
    live = console.is_terminal and not console.is_dumb_terminal and not verbose
    return LiveReporter(console) if live else PlainReporter(console)
