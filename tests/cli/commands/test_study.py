"""The command `study`: what it refuses, and what it says in the end."""

from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.study.engine import RUNS
from pipeline.study.store import Store
from pipeline.study.study import BASE, STUDY
from tests.cli.calls import invoke
from tests.study.fakes import cases_of, done_row


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("nowhere.yaml",), "nowhere.yaml cannot be used"),
        (("a.yaml", "b"), "only the word report is followed by a folder"),
        (("a.yaml", "--scheduler", "tcp://x:1", "--workers", "2"), "--workers is for this machine"),
        (("report", "x", "--workers", "2"), "--workers cannot go with study report"),
        (("report", "x", "--out", "y", "--retry"), "--out and --retry cannot go with study report"),
        (("report", "x", "--scheduler", "tcp://x:1"), "--scheduler cannot go with study report"),
        (("report", "nowhere"), "is not the folder of a study"),
    ],
)
def test_bad_usage(arguments: tuple[str, ...], said: str) -> None:
    """One message, and exit code 2."""
    result = invoke("study", *arguments)
    assert result.exit_code == 2
    assert said in result.stderr


def test_a_report_counts_endings_and_notes_figures_that_are_missing(tmp_path: Path, quick_config: Config) -> None:
    """Of a study that is not finished, too; the folder needs no other file than its own."""
    cases = cases_of(tmp_path, quick_config, figures=["path.kappa_max", "path.kapa"])
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / BASE).write_text((tmp_path / "base.yaml").read_text())
    (folder / STUDY).write_text((tmp_path / "tilts.yaml").read_text())
    first = next(iter(cases))
    with Store(folder) as store:
        store.set_program("1")
        store.add(done_row(first))
    result = invoke("study", "report", folder)
    assert result.exit_code == 0
    assert "1 of 3 runs" in " ".join(result.stdout.split())
    assert "no run has the figure path.kapa; near it are path.kappa_max" in result.stderr
    assert f'href="{RUNS}/{first.folder}/"' in (folder / "report.html").read_text()
