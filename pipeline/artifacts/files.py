"""Files written whole or not at all, their hashes, and values that JSON can hold."""

import contextlib
import dataclasses
import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

_PARTIAL = ".part"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that whoever looks finds the old content or the new one, never a part of it."""
    with parked(path.parent, {path.name: content}) as place:
        place()


@contextlib.contextmanager
def parked(folder: Path, files: Mapping[str, bytes]) -> Iterator[Callable[[], None]]:
    """Write files under temporary names in their own folders; call what is given to rename them into place.

    What was not renamed at the end is removed, so that a failure leaves everything as it was.
    """
    waiting: dict[Path, Path] = {}

    def place() -> None:
        for temporary, final in waiting.items():
            temporary.replace(final)

    try:
        for name, content in files.items():
            final = folder / name
            final.parent.mkdir(parents=True, exist_ok=True)
            temporary = final.with_name(f".{final.name}.{os.getpid()}{_PARTIAL}")
            waiting[temporary] = final
            temporary.write_bytes(content)
        yield place
    finally:
        for temporary in waiting:
            temporary.unlink(missing_ok=True)


def remove_partial(folder: Path) -> None:
    """Remove temporary files that a killed process left behind."""
    for leftover in folder.rglob(f".*{_PARTIAL}"):
        leftover.unlink(missing_ok=True)


def sha256(path: Path) -> str | None:
    """Hash a file's content; None where there is no such file."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
        return None


def json_bytes(value: object) -> bytes:
    """Write a value as indented JSON, ending with a newline; see `plain` for what becomes of it."""
    return (json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def plain(value: object) -> Any:
    """Reduce a value to what JSON can hold: NaN and infinities become null, anything unknown its text."""
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return str(value)
