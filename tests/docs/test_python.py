"""README and documentation beside a finished run: Python runs, page by page, and every figure is described."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline import Config, RunOptions, Stage, dump_config, load_config, run_pipeline
from pipeline.study.table import table_of, write_table
from tests.docs.pages import PAGES, PROJECT, blocks, inline_code, page_name
from tests.study.fakes import cases_of, done_row

COARSE = {
    "name": "quick",
    "refine.nodes": 40,
    "refine.coefficients": 16,
    "refine.max_meshes": 1,
    "refine.check_points": 1000,
    "retime.jerk": False,
    "retime.grid_points": 100,
    "retime.bound_points": 100,
}
"""What makes a run so coarse that it takes a few seconds: pages are about names and calls, not about its result."""


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory, vary: Callable[[Config, dict[str, object]], Config]) -> Path:
    """Run a coarse copy of `quick.yaml` up to its trajectory, as `configs/quick.yaml`, and tabulate a study."""
    folder = tmp_path_factory.mktemp("reader")
    config = vary(load_config(PROJECT / "configs" / "tiny.yaml"), COARSE)
    (folder / "configs").mkdir()
    (folder / "configs" / "quick.yaml").write_text(dump_config(config))
    run_pipeline(config, folder / "results" / "quick", RunOptions(last=Stage.RETIME))
    cases = cases_of(tmp_path_factory.mktemp("study"), config)
    write_table(folder / "results" / "tilts", table_of(cases, [(case, done_row(case)) for case in cases]))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")], ids=page_name)
def test_it_runs(page: Path, finished_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of a page, one after the other, as a reader would type them."""
    if any("import pandas" in code for code in blocks(page, "python")):
        pytest.importorskip("pandas")
    shutil.copytree(finished_run, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for code in blocks(page, "python"):
        exec(compile(code, page_name(page), "exec"), names)


@pytest.mark.slow
def test_the_summary_is_described(finished_run: Path) -> None:
    """Every figure of `summary.json` is in its page, whatever the section it is in."""
    summary = json.loads((finished_run / "results" / "quick" / "summary.json").read_text())
    described = set(inline_code(PROJECT / "docs" / "reference" / "summary.md"))
    sections = {name: section for name, section in summary.items() if isinstance(section, dict) and name != "versions"}
    figures = {key for section in sections.values() for key in section}
    figures |= {key for name in ("usage", "back") for key in sections["trajectory"][name]}
    figures |= set(sections["path"]["quality"])
    assert set(summary) | figures <= described | set(sections)
