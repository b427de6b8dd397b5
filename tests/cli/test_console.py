"""What reaches the terminal."""

import subprocess
import sys
import unicodedata
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cli.console import messages_console, printable, results_console
from pipeline.cli.output import text_table
from pipeline.config import Config
from pipeline.config.file import dump_config
from tests.cli.calls import subprocess_env
from tests.fuzzing import fuzz

_ANY = st.text(st.characters(codec=None), max_size=30)
_TURNING = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"


@fuzz(100)
@given(text=_ANY)
def test_a_terminal_obeys_nothing(text: str) -> None:
    """No control character but tab and newline is left, nothing turns the writing, and UTF-8 can encode it all."""
    shown = printable(text)
    assert all(unicodedata.category(char) not in ("Cc", "Cs") or char in "\t\n" for char in shown)
    assert not set(shown) & set(_TURNING)
    shown.encode()
    assert printable(shown) == shown


@fuzz(100)
@given(text=_ANY, encoding=st.sampled_from(["ascii", "latin-1", "cp1252", "utf-8"]))
def test_every_encoding_can_show_it(text: str, encoding: str) -> None:
    """What the encoding does not have becomes an escape."""
    printable(text, encoding).encode(encoding)


@pytest.mark.parametrize(
    ("text", "encoding", "shown"),
    [
        ("größe", "utf-8", "größe"),
        ("größe", "ascii", "gr\\xf6\\xdfe"),
        ("\x1b[31mred", "utf-8", "\\x1b[31mred"),
        ("gr\udcc3\udcb6\udcc3\udc9fe", "utf-8", "größe"),
        ("caf\udce9", "utf-8", "caf\\xe9"),
        ("\udcc2\udc9b31m", "utf-8", "\\x9b31m"),
        ("\ud800", "utf-8", "\\ud800"),
        ("a\tb\nc", "utf-8", "a\tb\nc"),
        ("\u202eexe.yaml", "utf-8", "\\u202eexe.yaml"),
    ],
)
def test_examples(text: str, encoding: str, shown: str) -> None:
    """Umlauts stay where they can; bytes of file names in another locale are read as UTF-8."""
    assert printable(text, encoding) == shown


def test_tables_and_messages_are_shown_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is printed goes through one room: text, titles, headings, cells."""
    for stream, console in (("stdout", results_console), ("stderr", messages_console)):
        monkeypatch.setattr(sys, stream, StringIO())
        console().print(text_table("\x1b[1mtitle", ("\x1bhead",), [("\x1bcell",)]))
        console().print("\x1b]0;text\x07")
        written = getattr(sys, stream).getvalue()
        assert "\x1b" not in written
        assert written.count("\\x1b") == 4


def test_a_locale_without_umlauts(tmp_path: Path, quick_config: Config) -> None:
    """Files and folders have their names in UTF-8 in any locale, and printing them raises nothing."""
    (tmp_path / "größe.yaml").write_bytes(dump_config(quick_config.model_copy(update={"name": "größe"})).encode())
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "check", "größe.yaml"],
        cwd=tmp_path,
        env={**subprocess_env(), "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.isascii()
    assert b"gr\\xf6\\xdfe.yaml is valid" in done.stdout
