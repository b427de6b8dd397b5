"""Files written completely or not at all, their hashes, and values that JSON can hold."""

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
    """Write a file so that readers find the old content or the new one, never a part of it."""
    with staged(path.parent, {path.name: content}) as place:
        place()


@contextlib.contextmanager
def staged(folder: Path, files: Mapping[str, bytes]) -> Iterator[Callable[[], None]]:
    """Write files under temporary names in their own folders; call the function yielded to rename them into place.

    Files not renamed at the end are removed, so that a failure leaves everything as it was.
    """
    pending: dict[Path, Path] = {}

    def place() -> None:
        for temporary, final in pending.items():
            temporary.replace(final)

    try:
        for name, content in files.items():
            final = folder / name
            final.parent.mkdir(parents=True, exist_ok=True)
            temporary = final.with_name(f".{final.name}.{os.getpid()}{_PARTIAL}")
            pending[temporary] = final
            temporary.write_bytes(content)
        yield place
    finally:
        for temporary in pending:
            temporary.unlink(missing_ok=True)


def remove_partial(folder: Path) -> None:
    """Remove temporary files that a killed process left."""
    for leftover in folder.rglob(f".*{_PARTIAL}"):
        leftover.unlink(missing_ok=True)


def sha256(path: Path) -> str | None:
    """Hash a file's content; None if there is no such file."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
        return None


def json_bytes(value: object) -> bytes:
    """Write a value as indented JSON, ending with a newline; `jsonable` says how values are converted."""
    return (json.dumps(jsonable(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


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
