"""The process that plans as the page sees it: begun, heard, and stopped."""

import contextlib
import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

from pipeline.parallel import module_command, module_environment
from pipeline.stage import Stage

Listen = Callable[[dict[str, Any]], None]
_PATIENCE_S = 5.0
"""How long it may take to end when it is asked to."""


class Planning:
    """A process that plans a configuration into a run folder.

    `listen` is called in a thread of its own with what happens: `stage`, `message` and perhaps `fraction`; at last
    `failure`, which is empty if all went well.
    """

    def __init__(self, file: Path, folder: Path, last: Stage, listen: Listen) -> None:
        self._process = subprocess.Popen(
            module_command("pipeline.show.planning", os.fspath(file), os.fspath(folder), last),
            env=module_environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._thread = Thread(target=self._hear, args=(listen,), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ask the process to end; what it tells last says so."""
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()

    def close(self) -> None:
        """End the process, and wait for it."""
        self.stop()
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._thread.join()
        for output in (self._process.stdout, self._process.stderr):
            if output is not None:
                output.close()

    def _hear(self, listen: Listen) -> None:
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        errors: list[str] = []
        stderr = self._process.stderr
        reader = Thread(target=lambda: errors.append(stderr.read()), daemon=True)
        reader.start()
        ended = False
        for line in self._process.stdout:
            event = json.loads(line)
            # Asked to stop while it ends, it may end twice.
            if not ended:
                ended = "failure" in event
                listen(event)
        reader.join()
        code = self._process.wait()
        if not ended:
            listen({"failure": f"planning ended unexpectedly (exit code {code})\n{''.join(errors)}".strip()})
