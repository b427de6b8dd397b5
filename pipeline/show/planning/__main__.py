"""The process that plans: `python -m pipeline.show.planning CONFIG DIR STAGE`; it ends when its standard input does."""

import json
import os
import signal
import sys
from pathlib import Path
from threading import Thread


def _end_with_parent() -> None:
    """Interrupt this process once nobody is there any more who could ask for it."""
    sys.stdin.buffer.read()
    os.kill(os.getpid(), signal.SIGINT)


if __name__ == "__main__":
    # Ctrl-C in the terminal is the parent's to handle; an interrupt of this process is an exception.
    os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Thread(target=_end_with_parent, daemon=True).start()
    with os.fdopen(os.dup(1), "w", buffering=1) as output:
        # Solvers may print.
        os.dup2(2, 1)
        from pipeline.show.planning.work import plan

        plan(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], lambda event: print(json.dumps(event), file=output))
    # The other thread still listens.
    os._exit(0)
