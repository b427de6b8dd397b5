"""A function that runs in a second process while this one does something else.

The process is a program of its own (`python -m pipeline.certify.following.second_process`): it reads the function and
what it is given from its input, and writes what it returns to its output. It ends with the process that began it.
"""

import contextlib
import os
import pickle
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from typing import IO, Any, Generic, TypeVar, cast

from pipeline.parallel import module_command, module_environment, processors

_T = TypeVar("_T")
_SIZE = struct.Struct(">Q")


class Call(Generic[_T]):
    """A call that may be under way in a second process; without one it is made when its result is asked for."""

    def __init__(self, process: "subprocess.Popen[bytes] | None") -> None:
        self._process = process

    def result(self, otherwise: Callable[[], _T]) -> _T:
        """Wait for the result; where there is no other process, or it failed, compute it here."""
        if self._process is None or self._process.stdout is None:
            return otherwise()
        content = _received(self._process.stdout)
        return otherwise() if content is None else cast("_T", pickle.loads(content))


@contextmanager
def begun(function: Callable[..., _T], *given: object) -> Iterator[Call[_T]]:
    """Begin to call a function of a module in a second process, if there is a processor for it.

    The process is ended with the context, whatever it is doing.
    """
    process = _start() if processors() > 1 and sys.executable else None
    try:
        if process is not None and process.stdin is not None:
            # A process that has ended takes nothing, and gives nothing.
            with contextlib.suppress(OSError):
                _send(process.stdin, pickle.dumps((function, given)))
        yield Call[_T](process)
    finally:
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                with contextlib.suppress(OSError):
                    if stream is not None:
                        stream.close()


def _start() -> "subprocess.Popen[bytes] | None":
    """Start the process in a session of its own: Ctrl-C is left to this one."""
    with contextlib.suppress(OSError):
        return subprocess.Popen(
            module_command(__name__),
            # This process needs the other processor: linear algebra in threads only waits for it.
            env={**module_environment(), "OPENBLAS_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    return None


def _send(stream: IO[bytes], content: bytes) -> None:
    stream.write(_SIZE.pack(len(content)) + content)
    stream.flush()


def _received(stream: IO[bytes]) -> bytes | None:
    """Read what was sent; None if it is not all there."""
    head = stream.read(_SIZE.size)
    if len(head) < _SIZE.size:
        return None
    (size,) = _SIZE.unpack(head)
    content = stream.read(size)
    return content if len(content) == size else None


def _end_with(stream: IO[bytes]) -> None:
    """End this process when the one that began it does."""
    stream.read()
    os._exit(1)


def _work(source: IO[bytes], output: IO[bytes]) -> None:
    asked = _received(source)
    if asked is None:
        return
    Thread(target=_end_with, args=(source,), daemon=True).start()
    function, given = cast("tuple[Callable[..., Any], tuple[Any, ...]]", pickle.loads(asked))
    _send(output, pickle.dumps(function(*given)))


if __name__ == "__main__":
    answer = os.fdopen(os.dup(1), "wb")
    # Solvers may print.
    os.dup2(2, 1)
    try:
        _work(sys.stdin.buffer, answer)
    finally:
        # The other thread still listens.
        os._exit(0)
