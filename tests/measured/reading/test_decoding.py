"""Bytes become lines by what they are, never by the locale."""

from pathlib import Path

import pytest

from pipeline.errors import UsageError
from pipeline.measured.reading.decoding import MOST_BYTES, MOST_CHARACTERS, MOST_LINES, decode_lines, read_bytes

TEXT = "t_s,größe\r\n1,\u2212\u00b5\n2,c\rd\x0be\u2028f\n"
LINES = ["t_s,größe", "1,\u2212\u00b5", "2,c", "d\x0be\u2028f"]


@pytest.mark.parametrize(("codec", "name"), [("utf-8", "UTF-8"), ("utf-8-sig", "UTF-8"), ("utf-16", "UTF-16")])
def test_unicode(codec: str, name: str) -> None:
    """Line ends of all systems end a line, nothing else does, and there is no byte order mark left."""
    assert decode_lines(TEXT.encode(codec), "f") == (LINES, name)


@pytest.mark.parametrize("codec", ["utf-16-le", "utf-16-be"])
def test_utf16_without_a_mark(codec: str) -> None:
    """Every other byte of a text in ASCII is zero."""
    text = "t_s,x_m\n0.5,1.25\n" * 3
    assert decode_lines(text.encode(codec), "f") == (text.splitlines(), "UTF-16")


def test_windows() -> None:
    """What is not UTF-8 is what Excel writes in western countries, and it is said."""
    assert decode_lines("t_s;größe\n1;5 µm €\n".encode("cp1252"), "f") == (["t_s;größe", "1;5 µm €"], "Windows-1252")


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"", "is empty"),
        (b"\xef\xbb\xbf \r\n\t\n", "is empty"),
        (b"PK\x03\x04xl/workbook.xml", r"a workbook \(.xlsx\).*\n.*CSV UTF-8"),
        (b"\xd0\xcf\x11\xe0\xa1", r"a workbook \(.xls\)"),
        (b"\x1f\x8b\x08", "compressed"),
        (b"%PDF-1.7", "a PDF"),
        (b"\x93NUMPY\x01", "an array of NumPy"),
        (b"t_s,x_m\n1,2\n1,\x002\n", "f, line 3: a zero byte"),
        (b"\0" * 5000, "a zero byte"),
        (b"t_s\n1\n\x81\n", "f, line 3: byte 0x81 is neither UTF-8 nor Windows-1252"),
        (b"\xef\xbb\xbft_s\n\xfc\n", "f, line 2: bytes that are not UTF-8"),
        ("t_s\n1\n".encode("utf-16") + b"\x00", "f, line 3: bytes that are not UTF-16"),
        ("t_s\n".encode("utf-32"), "a zero byte"),
    ],
)
def test_what_is_no_text(data: bytes, expected: str) -> None:
    """Workbooks, archives, damaged and other files are named, with the line where there is one, and what to do."""
    with pytest.raises(UsageError, match=expected) as caught:
        decode_lines(data, "f")
    assert "What to change" in str(caught.value)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"\n" * (MOST_LINES + 1), f"{MOST_LINES + 1:,} lines; a measurement may have {MOST_LINES:,}"),
        (b"\r\n" * (MOST_LINES + 1), f"{MOST_LINES + 1:,} lines"),
        (b"t_s,x_m\n" + b"," * (MOST_CHARACTERS), f"f, line 2: {MOST_CHARACTERS + 1:,} characters in a line"),
    ],
)
def test_what_is_too_long(data: bytes, expected: str) -> None:
    """Lines are counted before they are taken apart."""
    with pytest.raises(UsageError, match=expected):
        decode_lines(data + b"x", "f")


def test_a_file_without_end_is_refused() -> None:
    """No more is read than a measurement may have."""
    with pytest.raises(UsageError, match=f"more than the {MOST_BYTES:,} bytes"):
        read_bytes(Path("/dev/zero"))
