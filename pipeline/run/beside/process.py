"""The second process as the run sees it: begun, asked, and ended with the run."""

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Self

from pipeline.config import Config
from pipeline.parallel import processors


class SecondProcess:
    """A process that makes a part of the figures and the report of a run folder; without one, there is no answer."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process, whatever it is doing."""
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        for stream in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()
        process.wait()

    def begin(self, config: Config) -> None:
        """Begin with what needs no more than regions, route and path; a second processor is needed, or nothing is."""
        if self._process is not None or processors() < 2 or not sys.executable:
            return
        # Where this process finds its modules, in that order, and nothing else.
        path = os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)
        with contextlib.suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "pipeline.run.beside", os.fspath(self._folder)],
                env={**os.environ, "PYTHONPATH": path},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            self._tell(json.dumps(config.model_dump(mode="json")))

    def ask(self) -> None:
        """Ask for the rest: proof and trajectory, too, are in the folder."""
        self._tell("finish")

    def answer(self) -> dict[str, bytes] | None:
        """Wait for the files by name; None if there is no such process, or it failed."""
        if self._process is None or self._process.stdout is None:
            return None
        head, _, content = self._process.stdout.read().partition(b"\n")
        if self._process.wait() != 0:
            return None
        files, begin = {}, 0
        for name, size in json.loads(head).items():
            files[name] = content[begin : begin + size]
            begin += size
        return files

    def _tell(self, line: str) -> None:
        if self._process is not None and self._process.stdin is not None:
            # A process that has ended gives no answer.
            with contextlib.suppress(OSError):
                self._process.stdin.write(line.encode() + b"\n")
                self._process.stdin.flush()
