"""The names of files."""

from pathlib import Path

from pipeline.artifacts import (
    existing_files,
)
from pipeline.run.stage_specs import SPECS, spec_of
from pipeline.stage import Stage
from tests.artifacts.saved import put


def test_files_of_a_stage(tmp_path: Path) -> None:
    """Results, pictures and diagnoses are found with the stage that made them."""
    put(tmp_path, {"route.csv": b"", "figures/a.png": b"", "failed/route.json": b"", "figures/a.txt": b""})
    put(tmp_path, {"figures/a.pdf": b""})
    assert existing_files(tmp_path, spec_of(SPECS, Stage.ROUTE).patterns) == ["route.csv", "failed/route.json"]
    assert existing_files(tmp_path, spec_of(SPECS, Stage.FIGURES).patterns) == ["figures/a.png", "figures/a.pdf"]
    assert existing_files(tmp_path, spec_of(SPECS, Stage.RETIME).patterns) == []
