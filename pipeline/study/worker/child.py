"""The process that runs cases for a worker, one after the other: `python -m pipeline.study.worker.child PARENT`.

A solver cannot be stopped from within its process, and may end it; here it ends this one, and the worker lives on.
Requests come as lines of JSON on standard input, rows go the same way to what was standard output.
"""

import contextlib
import ctypes
import json
import os
import signal
import sys
from queue import SimpleQueue
from threading import Thread

READY = b"ready\n"
"""What the process says when it can take requests: only then does the time of a run begin."""
_PR_SET_PDEATHSIG = 1
_MOST_BYTES = 1.5e9
"""Memory above which the worker ends the process after a case: what libraries keep for good does not add up."""


def die_with(parent: int) -> None:
    """End this process when its parent ends, however that ends, and whatever this process is doing."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _listen(lines: "SimpleQueue[bytes]") -> None:
    """Pass on requests; without a worker there is nothing to do."""
    for line in sys.stdin.buffer:
        lines.put(line)
    os._exit(1)


def main() -> None:
    """Answer requests until the worker ends."""
    die_with(int(sys.argv[1]))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=_listen, args=(requests,), daemon=True).start()
    with os.fdopen(os.dup(1), "wb") as output:
        # Solvers may print.
        os.dup2(2, 1)
        from pipeline.study.extra import library
        from pipeline.study.worker.task import run_case

        process = library("psutil").Process()
        output.write(READY)
        output.flush()
        while True:
            row = run_case(json.loads(requests.get()))
            answer = {"row": row.data(), "spent": process.memory_info().rss > _MOST_BYTES}
            output.write(json.dumps(answer).encode() + b"\n")
            output.flush()


if __name__ == "__main__":
    main()
