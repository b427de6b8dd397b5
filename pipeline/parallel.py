"""Work in blocks: small enough for the cache, on all processors, with the results in order; and other processes.

NumPy releases the interpreter's lock in its loops, so that threads are enough for blocks.
"""

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

_T = TypeVar("_T")

THREADS = "GANTRY_TAU_THREADS"
"""The variable that says how many processors a process may take, where it shares them with others of its kind."""


def processors() -> int:
    """Count the processors that this process may use: those the system gives it, or fewer by the variable."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    allowed = os.environ.get(THREADS, "")
    return min(available, int(allowed)) if allowed.isdecimal() and int(allowed) > 0 else available


WORKERS = min(processors(), 4)
"""Number of threads; more than a few only wait for memory and for each other."""


def blocks(count: int, size: int) -> list[slice]:
    """Cut `count` rows into slices of at most `size`."""
    return [slice(begin, begin + size) for begin in range(0, count, size)]


def in_parallel(tasks: Iterable[Callable[[], _T]]) -> Iterator[_T]:
    """Run tasks on all processors; give their results in the order of the tasks."""
    with ThreadPoolExecutor(WORKERS) as pool:
        yield from pool.map(lambda task: task(), tasks)


def module_command(module: str, *arguments: str) -> list[str]:
    """Give the command that runs a module in a process of its own."""
    return [sys.executable, "-P", "-m", module, *arguments]


def module_environment() -> dict[str, str]:
    """Give the environment in which such a process finds modules where this one does, in that order."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)}
