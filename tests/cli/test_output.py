"""Where commands may write, and what they take for a path."""

import json
import os
from pathlib import Path
from typing import get_type_hints

import pytest
import typer.main

from pipeline.cli import app
from pipeline.config import Config
from tests.cli.calls import Call


@pytest.fixture(autouse=True)
def finished(call: Call, config_file: Path) -> None:
    """Run everything into the folder `out`."""
    assert call("run", config_file, "--out", "out").exit_code == 0


def test_an_empty_text_is_no_path(call: Call) -> None:
    """Not for arguments and not for options: it would be the working directory."""
    before = sorted(Path().rglob("*"))
    for arguments, named in (
        (("run", "machine.yaml", "--out", ""), "--out is empty"),
        (("run", "machine.yaml", "--out="), "--out is empty"),
        (("export", "out", "--output", ""), "--output is empty"),
        (("workspace", "machine.yaml", "--picture-3d", ""), "--picture-3d is empty"),
        (("route", "machine.yaml", "--write-mps", ""), "--write-mps is empty"),
        (("certify", "--check", ""), "--check is empty"),
        (("compare", ""), "an argument is empty"),
        (("compare", "out", ""), "an argument is empty"),
        (("check", ""), "an argument is empty"),
    ):
        result = call(*arguments)
        assert (result.exit_code, named in result.stderr) == (2, True), result.stderr
    assert sorted(Path().rglob("*")) == before


READ = ("--at", "--calibration", "--check", "--drives", "--machine", "--simulated")
"""Options that name files to be read; all others name what is written."""


def test_options_that_name_files_say_so() -> None:
    """What is refused when empty follows the help: FILE, DIR or RUN wherever a command takes a path.

    A file that is written need not be readable: what is wrong with it is found by who writes it.
    """
    for command in app.registered_commands:
        assert command.callback is not None
        shown = typer.main.get_command_from_info(command, pretty_exceptions_short=False, rich_markup_mode=None).params
        paths = {name for name, hint in get_type_hints(command.callback).items() if "Path" in str(hint)}
        options = [one for one in shown if one.name in paths and one.opts[0].startswith("-")]
        assert all(getattr(one, "metavar", "") in ("FILE", "DIR", "RUN") for one in options)
        written = [one for one in options if getattr(one, "metavar", "") == "FILE" and one.opts[0] not in READ]
        assert not any(one.type_descriptor.parameter_info.readable for one in written)


def test_results_are_not_overwritten(call: Call) -> None:
    """Neither those of the run that is read, nor those of any other, by any option."""
    before = {path: path.read_bytes() for path in Path("out").rglob("*") if path.is_file()}
    Path("link.png").symlink_to("out/figures/route.png")
    for arguments in (
        ("export", "out", "--output", "out/new.csv"),
        ("report", "out", "--output", "out/state.json"),
        ("measured", "out", "seen.csv", "--picture", "out/figures/route.png"),
        ("workspace", "machine.yaml", "--step", "0.2", "--picture", "out/figures/route.png"),
        ("workspace", "machine.yaml", "--step", "0.2", "--picture", "link.png"),
        ("workspace", "machine.yaml", "--step", "0.2", "--picture-3d", "out/figures/new.png"),
    ):
        result = call(*arguments)
        assert (result.exit_code, "not overwritten" in result.stderr) == (2, True), result.stderr
    assert {path: path.read_bytes() for path in Path("out").rglob("*") if path.is_file()} == before


def test_two_pictures_need_two_files(call: Call) -> None:
    """The second would overwrite the first."""
    result = call("workspace", "machine.yaml", "--step", "0.2", "--picture", "a.png", "--picture-3d", "./a.png")
    assert result.exit_code == 2
    assert "the same file" in result.stderr


def test_a_file_beside_the_output_is_not_overwritten(call: Call) -> None:
    """Unless it is of the same kind; and beside what is no file there is none."""
    for content in ("{}", "[]", "", '{"simulated": true}', "[" * 10_000):
        Path("package.json").write_text(content)
        result = call("simulate-measurement", "out", "--output", "package.csv")
        assert (result.exit_code, "package.json" in result.stderr) == (2, True)
        assert Path("package.json").read_text() == content
        assert not Path("package.csv").exists()
    Path("linked.json").symlink_to("package.json")
    assert call("simulate-measurement", "out", "--output", "linked.csv").exit_code == 2
    for _ in range(2):
        assert call("simulate-measurement", "out", "--output", "seen.csv").exit_code == 0
        assert json.loads(Path("seen.json").read_text())["simulated"] is True
    assert call("simulate-measurement", "out", "--output", os.devnull).exit_code == 0
    assert not Path(f"{os.devnull}.json").exists()


def test_alternatives_are_refused_before_the_first(call: Call, fast_config: Config) -> None:
    """A link in the folder of the second, which nobody named, costs the first nothing."""
    Path("new-2").mkdir()
    Path("new-2/route.csv").symlink_to("../out/route.csv")
    result = call("route", "machine.yaml", "--alternatives", 2, "--out", "new")
    assert result.exit_code == 2
    assert "new-2/route.csv is a link" in result.stderr
    assert not Path("new").exists()
