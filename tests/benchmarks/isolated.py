"""A process of its own for every measurement: a time limit, its own peak memory, and no library in another's way."""

import importlib
import multiprocessing
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

FINISHED = "finished"
_STATUS = Path("/proc/self/status")


@dataclass(frozen=True)
class Measured:
    """What a measurement told before it ended, and how it ended: `FINISHED`, or why not."""

    figures: dict[str, Any]
    ended: str


def measure(task: str, arguments: tuple[object, ...], limit_s: float) -> Measured:
    """Run a task "module:function" in a new process and collect the figures it yields as dictionaries.

    Figures told before the time limit, or before the process died, are kept.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(sender, task, arguments))
    figures: dict[str, Any] = {}
    deadline = time.monotonic() + limit_s
    process.start()
    sender.close()
    ended = ""
    try:
        ended = _collect(receiver, deadline, figures)
    finally:
        if not ended:  # the time is up, or the user has had enough
            process.kill()
        process.join()
    if ended == FINISHED:
        ended = _ending(process.exitcode or 0)
    return Measured(figures, ended or f"not finished in {limit_s:g} s")


def _collect(receiver: Connection, deadline: float, figures: dict[str, Any]) -> str:
    """Take figures until the process closes its end or the time is up; then the answer is empty."""
    while receiver.poll(max(0.0, deadline - time.monotonic())):
        try:
            figures.update(receiver.recv())
        except EOFError:
            return FINISHED
    return ""


def _ending(exit_code: int) -> str:
    if exit_code == 0:
        return FINISHED
    return f"killed by signal {-exit_code}" if exit_code < 0 else "failed, see its traceback"


def _work(sender: Connection, task: str, arguments: tuple[object, ...]) -> None:
    module, function = task.split(":")
    try:
        code = getattr(importlib.import_module(module), function)
    except ModuleNotFoundError as error:
        sender.send({"status": f"{error.name} is not installed"})
        return
    for figures in code(*arguments):
        sender.send(figures)


def peak_mb() -> float:
    """Most memory this process has had, in MB.

    Linux hands ru_maxrss down from the process that started this one, so that its own high-water mark is read.
    """
    if _STATUS.exists():
        (line,) = (line for line in _STATUS.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024 / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6


@contextmanager
def stopwatch(figures: dict[str, Any], name: str) -> Iterator[None]:
    """Put the seconds that the block takes into the figures."""
    begin = time.perf_counter()
    yield
    figures[name] = time.perf_counter() - begin
