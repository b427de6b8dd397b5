"""What a worker does with a request: it has a process of its own run the case, and stops that when its time is up."""

import contextlib
import os
import select
import signal
import subprocess
import threading
import time
from json import dumps, loads
from typing import Any

from pipeline.errors import PipelineError
from pipeline.parallel import THREADS, module_command, module_environment
from pipeline.study.program import program_version
from pipeline.study.rows import Ending
from pipeline.study.worker.task import failed_row, keep_row, known_row

_BLAS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
START_S = 300.0
"""Time in which the process has to start: libraries may come from a slow disk."""
_local = threading.local()
"""The process of every thread of this worker."""


class ProcessEndedError(PipelineError):
    """The process of a case ended, for lack of memory or by a fault of a library, or did not start."""


class Process:
    """A process that runs cases, with as many threads as they may use, and that has to start in a time."""

    def __init__(self, threads: int, start_s: float = START_S) -> None:
        self.threads = threads
        self._start_s = start_s
        self._ready = False
        pinned = dict.fromkeys((*_BLAS, THREADS), str(threads))
        self._process = subprocess.Popen(
            module_command("pipeline.study.worker.child", str(os.getpid())),
            env={**module_environment(), **pinned},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    @property
    def lives(self) -> bool:
        """Whether the process can take another case."""
        return self._process.poll() is None

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        """Send a request, and wait for the row.

        Raises
        ------
        TimeoutError
            When the time of the run is up.
        ProcessEndedError
            When the process did not start in time, or ended before it answered; says how.
        """
        if not self._ready:
            try:
                self._line(self._start_s)
            except TimeoutError:
                raise ProcessEndedError(f"its process did not start in {self._start_s:g} s") from None
            self._ready = True
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):
            self._process.stdin.write(dumps(request).encode() + b"\n")
            self._process.stdin.flush()
        answer = loads(self._line(request["time_limit_s"]))
        if answer["spent"]:
            self.end()
        return dict(answer["row"])

    def _line(self, seconds: float) -> bytes:
        """Wait for a line of the process."""
        assert self._process.stdout is not None
        output, line = self._process.stdout.fileno(), b""
        until = time.monotonic() + seconds
        while not line.endswith(b"\n"):
            left = until - time.monotonic()
            if left <= 0.0 or not select.select([output], [], [], left)[0]:
                raise TimeoutError
            part = os.read(output, 2**16)
            if not part:
                raise ProcessEndedError(_how(self._process.wait()))
            line += part
        return line

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._process.kill()
        for stream in (self._process.stdin, self._process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()
        self._process.wait()


def run_request(request: dict[str, Any]) -> dict[str, Any]:
    """Answer a request: `row`, or `ended` if the process of the run ended, or `other` if this is another program."""
    if (mine := program_version()) != request["program"]:
        return {"other": mine}
    if known := known_row(request):
        return {"row": known.data()}
    process = _process(request["threads"])
    began = time.perf_counter()
    try:
        return {"row": process.ask(request)}
    except ProcessEndedError as error:
        process.end()
        return {"ended": str(error)}
    except TimeoutError:
        process.end()
        message = f"stopped after {request['time_limit_s']:g} s (run.time_limit_s)"
        row = failed_row(request, Ending.TIME_LIMIT, message, time.perf_counter() - began)
        return {"row": keep_row(request, row).data()}


def _process(threads: int) -> Process:
    """Give the process of this thread: a new one, if there is none that lives."""
    known: Process | None = getattr(_local, "process", None)
    if known is not None and (not known.lives or known.threads != threads):
        known.end()
        known = None
    if known is None:
        known = _local.process = Process(threads)
    return known


def _how(code: int) -> str:
    """Say how a process ended."""
    if code >= 0:
        return f"its process ended with exit code {code}"
    with contextlib.suppress(ValueError):
        name = signal.Signals(-code).name
        hint = ", as for lack of memory" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{hint}"
    return f"its process was ended by signal {-code}"
