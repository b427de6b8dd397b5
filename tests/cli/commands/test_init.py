"""A configuration to start from, in a folder or a file that is not there yet."""

import json
import os
from pathlib import Path

import pytest

from pipeline.cli.commands.init import Base
from pipeline.config import Config
from pipeline.config.file import load_config
from tests.cli.calls import Call
from tests.conftest import CONFIGS


@pytest.mark.parametrize("base", Base)
def test_every_base_is_written_as_it_is(call: Call, base: Base) -> None:
    """The file has all that the base has, but for the name; every key is commented."""
    assert call("init", "my.yaml", "--base", base).exit_code == 0
    written = load_config("my.yaml")
    assert written == load_config(CONFIGS / f"{base}.yaml").model_copy(update={"name": "my"})
    assert f"# Started from {base}: " in Path("my.yaml").read_text()
    assert "tilt_max_deg: 30.0" in Path("my.yaml").read_text()


def test_a_folder(call: Call) -> None:
    """It is made, with the configuration named like it and the schema that the first line names."""
    result = call("init", "cells/left 2")
    assert result.exit_code == 0
    assert result.stderr == ""
    file, schema = Path("cells/left 2/left-2.yaml"), Path("cells/left 2/gantry-tau.schema.json")
    assert {file, schema} == set(Path("cells/left 2").iterdir())
    assert file.read_text().startswith(f"# yaml-language-server: $schema={schema.name}\n")
    assert json.loads(schema.read_text()) == Config.model_json_schema()
    assert load_config(file).name == "left-2"
    assert f"written: {file}\nwritten: {schema}\n" in result.stdout
    assert "Next: cd 'cells/left 2' && gantry-tau run left-2.yaml" in result.stdout


def test_this_folder(call: Call, tmp_path: Path) -> None:
    """An empty folder may be given as a dot; hidden files, such as those of git, do not count."""
    Path(".git").mkdir()
    result = call("init", ".")
    assert result.exit_code == 0
    (file,) = tmp_path.glob("*.yaml")
    assert f"Next: gantry-tau run {file.name}\n" in result.stdout


def test_what_is_written_is_accepted(call: Call) -> None:
    """`run` plans into a folder of the name, with nothing else there."""
    call("init", "cell", "--base", "quick")
    os.chdir("cell")
    assert call("run", "cell.yaml").exit_code == 0
    assert Path("results/cell/trajectory.csv").exists()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("full", "full is not empty: it holds a, b, c, .... Nothing was written.\n  What to change: give another"),
        ("full/a", "full/a is there already, and not a folder: give another NAME"),
        ("full/old.yaml", "full/old.yaml is there already, and not overwritten"),
        ("nowhere", "nowhere is there already, and not a folder"),
        ("nowhere.yaml", "nowhere.yaml is there already, and not overwritten"),
        ("full/a/b.yaml", "full/a is there already"),
        ("", "an argument is empty"),
    ],
)
def test_nothing_is_overwritten(call: Call, name: str, message: str) -> None:
    """What is there already, even a link that leads nowhere, is refused with exit code 2 and stays as it is."""
    Path("full").mkdir()
    for present in ("a", "b", "c", "old.yaml"):
        Path("full", present).write_text("mine")
    for link in ("nowhere", "nowhere.yaml"):
        Path(link).symlink_to("no-target")
    before = sorted(Path.cwd().rglob("*"))
    result = call("init", name)
    assert result.exit_code == 2
    assert message in result.stderr
    assert sorted(Path.cwd().rglob("*")) == before
    assert Path("full/old.yaml").read_text() == "mine"


def test_the_file_that_is_advised(call: Call) -> None:
    """A file of its own fits into a folder that has others."""
    Path("full").mkdir()
    Path("full/a").write_text("mine")
    assert "gantry-tau init full/my.yaml" in call("init", "full").stderr
    assert call("init", "full/my.yaml").exit_code == 0
    assert load_config("full/my.yaml").name == "my"


def test_an_unknown_base(call: Call) -> None:
    """It is refused with those that there are."""
    result = call("init", "my", "--base", "none")
    assert result.exit_code == 2
    assert "'none' is not one of" in result.stderr
    assert not Path("my").exists()
