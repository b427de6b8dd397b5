"""The code of the package is changed between two runs into the same folder."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config
from pipeline.run.up_to_date.source_code import PACKAGE
from tests.cli.calls import subprocess_env


@pytest.fixture
def copy(tmp_path: Path, quick_config: Config) -> Path:
    """Copy the package, with a configuration beside it."""
    (tmp_path / "quick.yaml").write_text(dump_config(quick_config))
    return shutil.copytree(PACKAGE, tmp_path / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__"))


def plan(copy: Path) -> str:
    """Run the copy up to the route, and give what it said."""
    done = subprocess.run(
        [sys.executable, "-m", PACKAGE.name, "route", "quick.yaml"],
        capture_output=True,
        text=True,
        cwd=copy.parent,
        env={**subprocess_env(), "PYTHONPATH": str(copy.parent)},
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def edit(file: Path, old: str, new: str) -> None:
    """Replace a text that must be there."""
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


@pytest.mark.slow
def test_a_key_of_the_summary_is_renamed(copy: Path) -> None:
    """The stage runs again, so that its words find the new key."""
    plan(copy)
    edit(copy / "summary" / "route.py", '"mode_changes"', '"changes_of_mode"')
    edit(copy / "summary" / "route.py", "['mode_changes']", "['changes_of_mode']")
    said = plan(copy)
    assert "regions: unchanged" in said
    assert "route: done" in said
    assert "changes_of_mode" in (copy.parent / "results" / "quick" / "summary.json").read_text()
    assert "route: unchanged" in plan(copy)


@pytest.mark.slow
def test_tables_are_written_with_fewer_decimals(copy: Path) -> None:
    """The table is written again, although the route is the same."""
    plan(copy)
    table = copy.parent / "results" / "quick" / "route.csv"
    before = table.read_text().splitlines()[1].split(",")
    edit(copy / "export" / "csv.py", "DECIMALS = 12", "DECIMALS = 6")
    assert "route: done" in plan(copy)
    after = table.read_text().splitlines()[1].split(",")
    decimals = [len(value.partition(".")[2]) for value in after if "." in value]
    assert decimals == [6] * sum("." in value for value in before)
