"""Certificates as JSON: read only if they are of a size that a certificate can have, and of finite numbers."""

import json
import stat
from collections import Counter
from pathlib import Path
from typing import Any, NoReturn

from pipeline.errors import UsageError

ADVICE = "\n  What to change: certify the path again: gantry-tau certify CONFIG --force"
MOST_BOXES = 150_000
"""Most boxes of all chains of a file: those of the path itself (`certify.chain.MOST_BOXES`), and of tolerances."""
_MOST_BYTES, _MOST_VALUES = 1_200 * MOST_BOXES, 60 * MOST_BOXES
"""A box and the joint at its end are 42 numbers in 8 lists, of up to 25 bytes each."""
_MOST_KEYS = 1_000
"""Most keys of a section: those of a certificate have about 20."""


def read_certificate_json(file: Path) -> dict[str, Any]:
    """Read a JSON object of finite numbers without duplicate keys; sizes are counted before anything is made of it.

    Raises
    ------
    UsageError
        When the file does not exist, is not a file, is too large, or is not such an object.
    """
    try:
        status = file.stat()
    except FileNotFoundError:
        raise UsageError(f"{file} does not exist.\n  What to change: give the certificate.json of a run.") from None
    except OSError as error:
        raise UsageError(f"{file} cannot be read: {error.strerror}.{ADVICE}") from None
    if not stat.S_ISREG(status.st_mode):
        raise UsageError(f"{file} is not a file.\n  What to change: give the certificate.json of a run.")
    _require_size(file, "bytes", status.st_size, _MOST_BYTES)
    try:
        text = file.read_bytes()
    except OSError as error:
        raise UsageError(f"{file} cannot be read: {error.strerror}.{ADVICE}") from None
    _require_size(file, "values", sum(map(text.count, (b",", b"[", b"{"))), _MOST_VALUES)
    data = _parse(file, text)
    if not isinstance(data, dict):
        raise UsageError(f"{file} is not a certificate: it has no keys.{ADVICE}")
    return data


def _require_size(file: Path, what: str, count: int, most: int) -> None:
    if count > most:
        raise UsageError(
            f"{file} holds {count:,} {what}; certificates of up to {MOST_BOXES:,} boxes have at most {most:,}.{ADVICE}"
        )


def _parse(file: Path, text: bytes) -> Any:
    def no_number(text: str) -> NoReturn:
        raise UsageError(f"{file} holds {text} where a number is expected.{ADVICE}")

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(pairs) > _MOST_KEYS:
            raise UsageError(f"{file} has a section of {len(pairs):,} keys; at most {_MOST_KEYS:,} are read.{ADVICE}")
        section = dict(pairs)
        if len(section) < len(pairs):
            twice = next(name for name, count in Counter(name for name, _ in pairs).items() if count > 1)
            raise UsageError(f"{file} has the key {twice} twice in one section.{ADVICE}")
        return section

    try:
        return json.loads(text, parse_constant=no_number, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise UsageError(f"{file} is damaged: it is not JSON from {place} on.{ADVICE}") from None
    except (ValueError, RecursionError):
        raise UsageError(f"{file} is damaged: it is not JSON.{ADVICE}") from None
