"""Certificates as JSON: what is far too large is refused before anything is made of it."""

import os
import pathlib

import pytest

from pipeline.artifacts.results.certificate.json_text import MOST_BOXES, read_certificate_json
from pipeline.errors import UsageError

LARGE = {
    "values": (b"[" + b"0," * (60 * MOST_BOXES + 1), r"holds 9,000,002 values; .* have at most 9,000,000"),
    "lists": (b'{"a": [' + b"[]," * (60 * MOST_BOXES + 1), r"values; certificates of up to 150,000 boxes"),
    "keys": (
        b"{" + b",".join(b'"%d": 1' % (k % 39_999) for k in range(40_000)) + b"}",
        "has a section of 40,000 keys; at most 1,000 are read",
    ),
    "digits": (b'{"a": ' + b"9" * 1_000_000 + b"}", "is damaged"),
    "depth": (b'{"a": ' + b"[" * 1_000_000, "is damaged"),
}


@pytest.mark.parametrize("name", LARGE)
def test_what_is_too_large_is_refused(tmp_path: pathlib.Path, name: str) -> None:
    """Naming the number, the limit, and what to do."""
    content, words = LARGE[name]
    file = tmp_path / "certificate.json"
    file.write_bytes(content)
    with pytest.raises(UsageError, match=words) as caught:
        read_certificate_json(file)
    assert "What to change" in str(caught.value)


def test_a_file_that_is_too_large_is_not_read(tmp_path: pathlib.Path) -> None:
    """A gigabyte of nothing takes no place on the disk, and none in memory."""
    file = tmp_path / "certificate.json"
    file.touch()
    os.truncate(file, 10**12)
    with pytest.raises(UsageError, match=r"holds 1,000,000,000,000 bytes; .* at most 180,000,000"):
        read_certificate_json(file)


def test_what_is_no_file_is_refused(tmp_path: pathlib.Path) -> None:
    """A pipe would be waited for, and a device never ends."""
    os.mkfifo(tmp_path / "pipe")
    for place in (tmp_path / "pipe", tmp_path, pathlib.Path("/dev/zero")):
        with pytest.raises(UsageError, match="is not a file"):
            read_certificate_json(place)
    with pytest.raises(UsageError, match="does not exist"):
        read_certificate_json(tmp_path / "none")


def test_a_key_given_twice_is_named(tmp_path: pathlib.Path) -> None:
    """At whatever depth, whichever it is."""
    file = tmp_path / "certificate.json"
    file.write_text('{"a": {"b": 1, "c": 2, "b": 1}}')
    with pytest.raises(UsageError, match="has the key b twice in one section"):
        read_certificate_json(file)
