"""Python in README and documentation: it runs, page by page, in a folder with configurations and a finished run."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline import Config, RunOptions, Stage, dump_config, load_config, run_pipeline
from tests.docs.pages import PAGES, PROJECT, blocks, page_name

COARSE = {
    "name": "quick",
    "refine.nodes": 40,
    "refine.coefficients": 16,
    "refine.max_meshes": 1,
    "refine.check_points": 1000,
    "certify.what": "nothing",
    "retime.jerk": False,
    "retime.grid_points": 100,
    "retime.bound_points": 100,
}
"""What makes a run so coarse that it takes a few seconds: pages are about names and calls, not about its result."""


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory, vary: Callable[[Config, dict[str, object]], Config]) -> Path:
    """Run a coarse copy of `quick.yaml` up to its trajectory, as `configs/quick.yaml` of an otherwise empty folder."""
    folder = tmp_path_factory.mktemp("reader")
    config = vary(load_config(PROJECT / "configs" / "tiny.yaml"), COARSE)
    (folder / "configs").mkdir()
    (folder / "configs" / "quick.yaml").write_text(dump_config(config))
    run_pipeline(config, folder / "results" / "quick", RunOptions(last=Stage.RETIME))
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
