"""Files where the user wants them: whole or not at all, with links kept, and pipes and devices written through."""

import errno
import os
import shutil
import stat
from pathlib import Path
from typing import BinaryIO

from pipeline.artifacts.files import naming, write_whole
from pipeline.regular_file import file_kind

_DESCRIPTORS = Path("/dev/fd")
"""The folder of the files that this process has open."""
_MOST_LINKS = 40
"""Links that the system follows at most."""


def write_output(path: Path, content: bytes) -> None:
    """Write a file that the user named.

    A regular file is replaced as a whole. Of a link the target is written. What is neither (a pipe, a device, an open
    file such as `/dev/stdout`) is written through.

    Raises
    ------
    OSError
        When it cannot be written; names the file as the user did.
    """
    with naming(path):
        if is_written_through(path):
            with _open_through(path) as file:
                file.write(content)
        else:
            write_whole(_target(path), content)


def place_output(written: Path, path: Path) -> None:
    """Put a file that was written in `output_folder(path)` where the user wants it, as `write_output` does.

    Raises
    ------
    OSError
        When it cannot be written; names the file as the user did.
    """
    with naming(path):
        if is_written_through(path):
            with written.open("rb") as source, _open_through(path) as file:
                shutil.copyfileobj(source, file)
        else:
            written.replace(_target(path))


def output_folder(path: Path) -> Path | None:
    """Give the folder in which a file is written before it is put in place; None: that of temporary files."""
    return None if is_written_through(path) else _target(path).parent


def check_writable(path: Path) -> None:
    """Refuse a file that cannot be written for what is there already, before anything is computed.

    Raises
    ------
    OSError
        When it is a folder or a socket, a file that may not be written, or a loop of links; names the file.
    """
    with naming(path):
        if not is_written_through(path):
            _target(path)


def is_written_through(path: Path) -> bool:
    """Check whether a file is written where it is, rather than replaced as a whole: a pipe, a device, an open file."""
    if _descriptor(path) is not None:
        return True
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    return stat.S_ISFIFO(mode) or stat.S_ISCHR(mode) or stat.S_ISBLK(mode)


def _target(path: Path) -> Path:
    """Give the regular file that is written, through links; it need not exist."""
    target = Path(os.path.realpath(path))
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        pass
    else:
        if not stat.S_ISREG(mode):
            kind = "a directory" if stat.S_ISDIR(mode) else file_kind(mode)
            raise OSError(errno.EISDIR, f"Is {kind}, not a file")
        if not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, "may not be written")
    folder = next(folder for folder in target.parents if folder.exists())
    if not os.access(folder, os.W_OK):
        raise PermissionError(errno.EACCES, f"may not be written: nothing may be written to its folder, {folder}")
    return target


def _open_through(path: Path) -> BinaryIO:
    descriptor = _descriptor(path)
    # Opening it by its name again would truncate a file that the shell appends to.
    return path.open("wb") if descriptor is None else os.fdopen(os.dup(descriptor), "wb")


def _descriptor(path: Path) -> int | None:
    """Give the number of the open file that a path such as `/dev/stdout` stands for, perhaps through links."""
    for _ in range(_MOST_LINKS):
        if path.name.isdecimal() and os.path.realpath(path.parent) == os.path.realpath(_DESCRIPTORS):
            return int(path.name)
        if not path.is_symlink():
            return None
        path = path.parent / path.readlink()
    return None
