"""The second process: it ends with the run that began it, and leaves Ctrl-C to that."""

import os
import signal
import sys
from pathlib import Path
from queue import SimpleQueue
from threading import Thread


def _listen(lines: "SimpleQueue[bytes]") -> None:
    """Pass on what the run says; without a run there is nothing to do."""
    for line in sys.stdin.buffer:
        lines.put(line)
    os._exit(1)


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    heard: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=_listen, args=(heard,), daemon=True).start()
    with os.fdopen(os.dup(1), "wb") as output:
        # Solvers may print.
        os.dup2(2, 1)
        from pipeline.run.beside.work import work

        work(Path(sys.argv[1]), heard.get, output)
    # The other thread still listens.
    os._exit(0)
