"""The second process: it ends with the run that began it, and leaves Ctrl-C to that."""

import gc
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


def _send(descriptor: int, contents: "SimpleQueue[bytes | None]") -> None:
    """Write what there is, while the next part is being made: the run may be slow to read it."""
    with os.fdopen(descriptor, "wb") as output:
        while (content := contents.get()) is not None:
            output.write(content)
            output.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # It ends after seconds, and looking for garbage among the many objects of figures takes a part of them.
    gc.disable()
    heard: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=_listen, args=(heard,), daemon=True).start()
    said: SimpleQueue[bytes | None] = SimpleQueue()
    sender = Thread(target=_send, args=(os.dup(1), said))
    # Solvers may print.
    os.dup2(2, 1)
    sender.start()
    try:
        from pipeline.run.beside.work import work

        work(Path(sys.argv[1]), heard.get, lambda: not heard.empty(), said.put)
    finally:
        said.put(None)
        sender.join()
    # The other thread still listens.
    os._exit(0)
