"""From bytes to lines: UTF-8, UTF-16 or Windows-1252, never what the locale says."""

import codecs
import re
from pathlib import Path

from pipeline.measured.reading.refusal import refusal

MOST_BYTES = 2**28
"""Largest file that is read: more than twice that of a million rows of two reflectors with twelve decimals."""
MOST_LINES, MOST_CHARACTERS = 1_200_000, 20_000
"""Most lines of a file, and most characters of a line; a motion has at most a million rows."""
_SAVE = "save it as CSV in UTF-8 (in Excel: Save As, CSV UTF-8)"
_SHORTEN = "leave out rows before and after the motion, and columns that are not needed, or measure less often."
_OTHER_FILES = {
    b"PK\x03\x04": "a workbook (.xlsx) or another zip archive",
    b"\xd0\xcf\x11\xe0": "a workbook (.xls)",
    b"\x1f\x8b": "compressed (.gz)",
    b"\x93NUMPY": "an array of NumPy (.npy)",
    b"%PDF-": "a PDF",
    b"{\\rtf": "a text document (.rtf)",
}
_LINE_END = re.compile("\r\n|\r|\n")
_SAMPLE = 4096


def read_bytes(file: Path) -> bytes:
    """Read a file that is not too large.

    Raises
    ------
    UsageError
        When it is; names the size and the limit.
    OSError
        When it cannot be read.
    """
    with file.open("rb") as stream:
        data = stream.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise refusal(
            str(file),
            f"more than the {MOST_BYTES:,} bytes that a measurement may have.",
            _SHORTEN,
        )
    return data


def decode_lines(data: bytes, file: str) -> tuple[list[str], str]:
    """Decode a text, and split it into lines; the second result names the encoding.

    Lines end with LF, CR LF or CR, as spreadsheets write them; a byte order mark is removed.

    Raises
    ------
    UsageError
        When the data are empty, not a text, in an encoding that cannot be told, or have too many or too long lines.
    """
    for magic, what in _OTHER_FILES.items():
        if data.startswith(magic):
            raise refusal(file, f"this is {what}, not a table as text.", _SAVE + ".")
    text, encoding = _decode(data, file)
    if not text.strip():
        raise refusal(file, "the file is empty.", "give a file with a header and rows.")
    if (count := text.count("\n") + text.count("\r") - text.count("\r\n")) > MOST_LINES:
        raise refusal(file, f"{count:,} lines; a measurement may have {MOST_LINES:,}.", _SHORTEN)
    lines = _LINE_END.split(text)
    if "\0" in text:
        line = next(number for number, one in enumerate(lines, 1) if "\0" in one)
        raise refusal(file, "a zero byte, which no text has: the file is damaged, or not a text.", _SAVE + ".", line)
    if len(longest := max(lines, key=len)) > MOST_CHARACTERS:
        what = f"{len(longest):,} characters in a line; a table may have {MOST_CHARACTERS:,}."
        raise refusal(file, what, f"leave out columns that are not needed; {_SAVE}.", lines.index(longest) + 1)
    if not lines[-1]:
        lines.pop()
    return lines, encoding


def _decode(data: bytes, file: str) -> tuple[str, str]:
    codec, marked = _wide_codec(data), data.startswith(codecs.BOM_UTF8)
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode(codec or "utf-8"), "UTF-16" if codec else "UTF-8"
    except UnicodeDecodeError as error:
        if not codec and not marked:
            return _decode_narrow(data, file), "Windows-1252"
        line = len(_LINE_END.split(data[: error.start].decode(codec or "utf-8", "replace")))
        name = "UTF-16" if codec else "UTF-8"
        raise refusal(file, f"bytes that are not {name}.", f"{_SAVE}.", line) from None


def _decode_narrow(data: bytes, file: str) -> str:
    """Decode Windows-1252, which Excel writes in western countries if not asked for UTF-8: of ASCII, a superset."""
    try:
        return data.decode("cp1252")
    except UnicodeDecodeError as error:
        line = len(_LINE_END.split(data[: error.start].decode("latin-1")))
        text = f"byte 0x{data[error.start]:02x} is neither UTF-8 nor Windows-1252."
        raise refusal(file, text, f"{_SAVE}.", line) from None


def _wide_codec(data: bytes) -> str | None:
    """Recognise UTF-16: by its byte order mark, or, without it, by every other byte of a text being zero."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    sample = data[:_SAMPLE]
    low, high = sample[::2], sample[1::2]
    if len(high) and high.count(0) > 0.9 * len(high) and not low.count(0):
        return "utf-16-le"
    if len(high) and low.count(0) > 0.9 * len(low) and not high.count(0):
        return "utf-16-be"
    return None
