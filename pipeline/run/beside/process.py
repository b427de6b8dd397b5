"""The second process as the run sees it: begun, told what is done, and ended with the run."""

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path
from threading import Condition, Thread
from types import TracebackType
from typing import BinaryIO, Self

from pipeline.config import Config
from pipeline.parallel import module_command, module_environment, processors
from pipeline.stage import Stage


class SecondProcess:
    """A process that makes parts of the figures and the report of a run folder as soon as what they need is there.

    Without a second processor, or where the process fails, the run makes all parts itself.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None
        self._reader: Thread | None = None
        self._said: list[str] = []
        self._changed = Condition()
        self._begun: set[str] = set()
        self._made: dict[str, dict[str, bytes]] = {}
        self._ended = False

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
        process.wait()
        if self._reader is not None:
            self._reader.join()
        for stream in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()

    def begin(self, config: Config) -> None:
        """Begin; a second processor is needed, or nothing is."""
        if self._process is not None or processors() < 2 or not sys.executable:
            return
        # The run needs the other processor: linear algebra in threads only waits for it.
        one = {"OPENBLAS_NUM_THREADS": "1"}
        with contextlib.suppress(OSError):
            process = subprocess.Popen(
                module_command("pipeline.run.beside", os.fspath(self._folder)),
                env={**module_environment(), **one},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
            self._process = process
            assert process.stdout is not None
            self._reader = Thread(target=self._read, args=(process.stdout,), daemon=True)
            self._reader.start()
            self._tell(json.dumps(config.model_dump(mode="json")))
            for line in self._said:
                self._tell(line)

    def done(self, stage: Stage) -> None:
        """Say that the result of a stage is in the folder."""
        self._say(f"done {stage}")

    def take(self, part: str) -> bool:
        """Take a part over, unless the process has begun with it."""
        with self._changed:
            if part in self._made or (part in self._begun and not self._ended):
                return False
        self._say(f"taken {part}")
        return True

    def files(self, part: str) -> dict[str, bytes] | None:
        """Wait for the files of a part by name; None if there is no such process, or it failed."""
        if self._process is None:
            return None
        with self._changed:
            self._changed.wait_for(lambda: part in self._made or self._ended)
            return self._made.get(part)

    def _say(self, line: str) -> None:
        """Tell the process, once it is there."""
        self._said.append(line)
        self._tell(line)

    def _tell(self, line: str) -> None:
        if self._process is not None and self._process.stdin is not None:
            # A process that has ended gives no answer.
            with contextlib.suppress(OSError):
                self._process.stdin.write(line.encode() + b"\n")
                self._process.stdin.flush()

    def _read(self, output: BinaryIO) -> None:
        """Take what the process writes until it ends."""
        for line in iter(output.readline, b""):
            part, sizes = json.loads(line)
            files = None if sizes is None else {name: output.read(size) for name, size in sizes.items()}
            complete = files is None or all(len(content) == sizes[name] for name, content in files.items())
            with self._changed:
                if files is None:
                    self._begun.add(part)
                elif complete:
                    self._made[part] = files
                self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()
