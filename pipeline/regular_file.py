"""Reading files whose size and kind nobody vouches for: regular files only, and at most so many bytes.

A pipe where a file of a run is expected would wait for ever, and a device would never end.
"""

import errno
import io
import os
import stat
from pathlib import Path
from typing import BinaryIO

_KINDS = {
    stat.S_IFREG: "a regular file",
    stat.S_IFDIR: "a folder",
    stat.S_IFLNK: "a link",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
"""What there is in a file system, in words."""
_PART = 2**20
"""Bytes read at a time."""


def file_kind(mode: int) -> str:
    """Say in words what a file is, from its `st_mode`."""
    return _KINDS.get(stat.S_IFMT(mode), "something else")


def open_regular_file(path: Path, most_bytes: int) -> io.BufferedReader:
    """Open a regular file, or a link to one, for reading; nothing else is even opened.

    Raises
    ------
    OSError
        When there is no such file, it cannot be read, is a folder, pipe, socket or device, or has more than
        `most_bytes`; its `strerror` is the rest of a sentence that begins with the file.
    """
    # Opening a pipe waits for a writer, and opening a device may do something.
    _require_regular(path, path.stat().st_mode)
    file = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC), "rb")
    try:
        status = os.fstat(file.fileno())
        _require_regular(path, status.st_mode)
        if status.st_size > most_bytes:
            raise _too_large(path, f"{status.st_size:,}", most_bytes)
    except OSError:
        file.close()
        raise
    return file


def read_regular_file(path: Path, most_bytes: int) -> bytes:
    """Read a regular file, or a link to one, as a whole.

    Raises
    ------
    OSError
        See `open_regular_file`.
    """
    with open_regular_file(path, most_bytes) as file:
        return _read_whole(path, file, most_bytes)


def read_named_file(path: Path, most_bytes: int) -> bytes:
    """Read a file that the user named, which may also be a pipe (`<(...)`) or a device (`/dev/stdin`), as a whole.

    Raises
    ------
    OSError
        When there is no such file, it cannot be read, or has more than `most_bytes`.
    """
    with path.open("rb") as file:
        return _read_whole(path, file, most_bytes)


def _read_whole(path: Path, file: BinaryIO, most_bytes: int) -> bytes:
    # A file may grow while it is read, and some have no size before; memory is taken up by what is there.
    content = bytearray()
    while part := file.read(min(_PART, most_bytes + 1 - len(content))):
        content += part
        if len(content) > most_bytes:
            raise _too_large(path, f"more than {most_bytes:,}", most_bytes)
    return bytes(content)


def _require_regular(path: Path, mode: int) -> None:
    if not stat.S_ISREG(mode):
        code = errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL
        raise OSError(code, f"is {file_kind(mode)}, not a regular file", str(path))


def _too_large(path: Path, size: str, most_bytes: int) -> OSError:
    return OSError(errno.EFBIG, f"has {size} bytes; at most {most_bytes:,} are read", str(path))
