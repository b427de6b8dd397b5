"""Files written completely or not at all, their hashes, and values that JSON can hold."""

import contextlib
import dataclasses
import errno
import hashlib
import json
import math
import os
import re
import secrets
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from pipeline.regular_file import file_kind, open_regular_file

MOST_BYTES = 2**34
"""Size of the largest file that is read: no result is larger."""

_PARTIAL = re.compile(r"\.(?P<name>.+)\.[0-9a-f]+\.part")
"""Names of files that are being written: the final name, something unique, and an ending."""
_MOST_CHARACTERS = 40
"""Characters of a final name in a temporary one: no name gets too long."""


def write_whole(path: Path, content: bytes) -> None:
    """Write a regular file so that readers find the old content or the new one, never a part of it.

    Raises
    ------
    OSError
        When it cannot be written, or something other than a regular file is there; names the file.
    """
    with staged(path.parent, {path.name: content}) as place:
        place()


def write_new(path: Path, content: bytes) -> None:
    """Write a file that is not there yet, completely or not at all; folders are made as needed.

    Raises
    ------
    FileExistsError
        When there is something of that name; names it.
    OSError
        When it cannot be written; names it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    temporary = _temporary(path)
    try:
        with naming(path):
            temporary.touch(exist_ok=False)
            temporary.write_bytes(content)
            _place_new(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def staged(folder: Path, files: Mapping[str, bytes]) -> Iterator[Callable[[], None]]:
    """Write files under temporary names in their own folders; call the function yielded to rename them into place.

    Files not renamed at the end are removed, so that a failure leaves everything as it was.

    Raises
    ------
    OSError
        When one cannot be written, or something other than a regular file is there; names the file.
    """
    pending: dict[Path, Path] = {}

    def place() -> None:
        for temporary, final in pending.items():
            with naming(final):
                temporary.replace(final)

    try:
        for name, content in files.items():
            final = folder / name
            final.parent.mkdir(parents=True, exist_ok=True)
            temporary = _temporary(final)
            with naming(final):
                old = _regular_status(final)
                pending[temporary] = final
                temporary.touch(exist_ok=False)
                temporary.write_bytes(content)
                _make_alike(temporary, old)
        yield place
    finally:
        for temporary in pending:
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def naming(final: Path) -> Iterator[None]:
    """Name the file that the user knows in errors of the system: not a temporary one, and not none."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(final)) from None


def remove_partial(folder: Path, patterns: Iterable[str]) -> None:
    """Remove what a killed process left of files in a folder whose names, relative to it, match one of the patterns."""
    wanted = set(patterns)
    for parent in {PurePosixPath(pattern).parent for pattern in wanted}:
        for entry in sorted((folder / parent).glob(".*.part")):
            found = _PARTIAL.fullmatch(entry.name)
            name = (parent / found["name"]).as_posix() if found else ""
            if any(fnmatchcase(name, one) for one in wanted) and stat.S_ISREG(entry.lstat().st_mode):
                entry.unlink(missing_ok=True)


def sha256(path: Path, most_bytes: int = MOST_BYTES) -> str | None:
    """Hash the content of a regular file; None if there is no such file, or it has more bytes."""
    try:
        with open_regular_file(path, most_bytes) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except PermissionError:
        raise
    except OSError:
        return None


def _temporary(final: Path) -> Path:
    """Name the file that a final one is written to first, beside it."""
    return final.with_name(f".{final.name[:_MOST_CHARACTERS]}.{secrets.token_hex(6)}.part")


def _place_new(temporary: Path, final: Path) -> None:
    """Give a file its final name, which nothing may have."""
    try:
        final.hardlink_to(temporary)
    except FileExistsError:
        raise
    except OSError:
        # Some file systems have no links.
        final.open("xb").close()
        try:
            temporary.replace(final)
        except BaseException:
            final.unlink()
            raise


def _regular_status(path: Path) -> os.stat_result | None:
    """Give the status of a regular file; None if there is nothing."""
    try:
        status = path.lstat()
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(status.st_mode):
        code = errno.EISDIR if stat.S_ISDIR(status.st_mode) else errno.EEXIST
        raise OSError(code, f"is {file_kind(status.st_mode)}, not a regular file")
    return status


def _make_alike(path: Path, old: os.stat_result | None) -> None:
    """Give a file the permissions, and where possible the owner, of the one that it replaces."""
    if old is not None:
        new = path.stat()
        if (old.st_uid, old.st_gid) != (new.st_uid, new.st_gid):
            with contextlib.suppress(PermissionError):
                os.chown(path, old.st_uid, old.st_gid)
        path.chmod(old.st_mode & 0o777)


def json_bytes(value: object) -> bytes:
    """Write a value as indented JSON, ending with a newline; `jsonable` says how values are converted."""
    return (json.dumps(jsonable(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode(
        errors="backslashreplace"
    )


def jsonable(value: object) -> Any:
    """Convert a value to what JSON can hold: NaN and infinities to null, unknown types to their text."""
    if isinstance(value, np.generic | np.ndarray):
        return jsonable(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [jsonable(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: jsonable(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return str(value)
