"""The process that plans: `python -m pipeline.show.planning CONFIG DIR STAGE`; it ends when its standard input does."""

import json
import os
import signal
import sys
from pathlib import Path
from threading import Event, Thread
from typing import Any


def _end_with_parent(asked: Event) -> None:
    """Interrupt this process once nobody is there any more who could ask for it."""
    sys.stdin.buffer.read()
    asked.set()
    os.kill(os.getpid(), signal.SIGINT)


if __name__ == "__main__":
    # Ctrl-C in the terminal is the parent's to handle; an interrupt of this process is an exception.
    os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with os.fdopen(os.dup(1), "w", buffering=1) as output:
        # Solvers may print.
        os.dup2(2, 1)
        from pipeline.show.planning.work import STOPPED, plan

        def tell(event: dict[str, Any]) -> None:
            """Write an event as a line."""
            print(json.dumps(event), file=output)

        asked = Event()
        try:
            # Interrupts begin here: within the import above, one would come out as an error of it.
            Thread(target=_end_with_parent, args=(asked,), daemon=True).start()
            plan(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], tell)
        except BaseException:
            # Stages import, too: whatever comes out of one that is interrupted means the same.
            if not asked.is_set():
                raise
            tell({"failure": STOPPED})
    # The other thread still listens.
    os._exit(0)
