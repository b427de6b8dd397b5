"""Key paths such as `machine.rails[0].y_m`: where they lead in nested data."""

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

from pipeline.errors import PipelineError

_PATH = re.compile(r"\w+(\[\d+\])*(\.\w+(\[\d+\])*)*")
_PART = re.compile(r"\w+")
_SUGGESTED = 3

Parts = tuple[str | int, ...]


class UnknownKeyError(PipelineError):
    """A path leads nowhere; its text says which are near."""


def parts_of(path: str) -> Parts:
    """Cut a path into keys and indices.

    Raises
    ------
    UnknownKeyError
        When it is not written as a path is.
    """
    if not _PATH.fullmatch(path):
        raise UnknownKeyError(f"{path!r} is not a key's path, such as task.tilt_max_deg or machine.rails[0].y_m")
    return tuple(
        int(part) if before == "[" else part
        for before, part in ((path[found.start() - 1 : found.start()], found[0]) for found in _PART.finditer(path))
    )


def value_at(data: Mapping[str, Any], path: str) -> Any:
    """Find the value at a path.

    Raises
    ------
    UnknownKeyError
        When there is none; names the nearest paths.
    """
    value: Any = data
    for part in parts_of(path):
        try:
            # Letters of a word are not keys.
            whole = None if isinstance(value, str) else value
            value = whole[part]  # type: ignore[index]  # None has no parts
        except (KeyError, IndexError, TypeError):
            known = [name for name, _ in flat(data)]
            near = difflib.get_close_matches(path, known, n=_SUGGESTED, cutoff=0.5)
            hint = f"; near it are {', '.join(near)}" if near else ""
            raise UnknownKeyError(f"{path} is not a key of the configuration{hint}") from None
    return value


def nested_paths(paths: Iterable[str]) -> tuple[str, str] | None:
    """Find two paths of which one begins the other, or leads to the same value; None if there are none.

    Raises
    ------
    UnknownKeyError
        When one is not written as a path is.
    """
    found: dict[Parts, str] = {}
    for path in sorted(paths, key=lambda one: len(parts_of(one))):
        parts = parts_of(path)
        if outer := next((found[parts[:n]] for n in range(1, len(parts) + 1) if parts[:n] in found), None):
            return outer, path
        found[parts] = path
    return None


def replaced(data: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Copy nested data with other values at some paths, each of which leads somewhere; the rest is shared."""
    copied = dict(data)
    for path, value in changes.items():
        copied = _with(copied, parts_of(path), value)
    return copied


def _with(data: Any, parts: Parts, value: Any) -> Any:
    """Copy what leads to a value, and share the rest with the original."""
    if not parts:
        return value
    copied = list(data) if isinstance(data, list) else dict(data)
    copied[parts[0]] = _with(data[parts[0]], parts[1:], value)  # type: ignore[index]  # an index leads into a list
    return copied


def flat(data: Any, path: str = "") -> list[tuple[str, Any]]:
    """List all values of nested data by their paths, sections and lists included."""
    found: list[tuple[str, Any]] = []
    if isinstance(data, Mapping):
        inner = [(f"{path}.{key}".lstrip("."), value) for key, value in data.items()]
    elif isinstance(data, list | tuple):
        inner = [(f"{path}[{index}]", value) for index, value in enumerate(data)]
    else:
        return found
    for name, value in inner:
        found.append((name, value))
        found += flat(value, name)
    return found


def scalars(data: Any) -> dict[str, Any]:
    """List the numbers, words and truth values of nested data by their paths; None is left out."""
    return {path: value for path, value in flat(data) if isinstance(value, bool | int | float | str)}
