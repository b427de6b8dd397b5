"""Commands in README and documentation: each is one that the program takes, with all its options."""

import re
import shlex
from pathlib import Path

import pytest
import typer

from pipeline.cli import app
from tests.docs.pages import PAGES, PROJECT, blocks, inline_code, page_name

_PROGRAM = re.compile(r"^(?:\.venv/bin/)?gantry-tau ")
_COMMAND_LINE = typer.main.get_command(app)
OTHERS = {"make", ".", "cp", "python3", "pip"}
"""Other programs that blocks use."""


def shell_lines(page: Path) -> list[str]:
    """Give the lines of shell blocks, continued ones as one, without comments."""
    lines = [line for code in blocks(page, "sh") for line in code.replace("\\\n", "").splitlines()]
    return [line for line in lines if line.strip() and not line.startswith("#")]


def parse(line: str) -> None:
    """Parse a command as the program does, without running it; raises where the program would refuse it."""
    arguments = shlex.split(line, comments=True)[1:]
    for sign in (">", "|", "<"):
        if sign in arguments:
            arguments = arguments[: arguments.index(sign)]
    if arguments == ["--version"]:
        return
    name, *rest = arguments
    command = _COMMAND_LINE.commands[name]
    command.make_context(name, rest)


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_every_command_is_taken(page: Path) -> None:
    """Names, options and values of commands in blocks and within the text are those of the program."""
    written = shell_lines(page) + inline_code(page)
    for line in filter(_PROGRAM.match, written):
        parse(line)


@pytest.mark.parametrize("line", ["gantry-tau chek a", "gantry-tau run a --onto b", "gantry-tau export a --format pdf"])
def test_a_wrong_command_is_found(line: str) -> None:
    """The check can fail: for a command, an option, and a value."""
    with pytest.raises(Exception, match=r"chek|--onto|pdf"):
        parse(line)


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_every_make_target_is_there(page: Path) -> None:
    """Blocks use few other programs, and of make only what the Makefile has."""
    targets = set(re.findall(r"^([a-z-]+):", (PROJECT / "Makefile").read_text(), re.MULTILINE))
    for line in shell_lines(page):
        program, *arguments = shlex.split(line, comments=True)
        assert _PROGRAM.match(line) or program in OTHERS, line
        if program == "make":
            assert arguments[0] in targets, line
    for code in inline_code(page):
        if match := re.fullmatch(r"make ([a-z-]+)", code):
            assert match[1] in targets, code
