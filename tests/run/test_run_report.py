"""What a run did, and what is worth opening."""

from pathlib import Path

from pipeline.run.run_report import files_to_open
from pipeline.stage import STAGES
from tests.artifacts.saved import put


def test_only_files_that_exist_are_recommended(tmp_path: Path) -> None:
    """Files of stages that wrote none are left out."""
    put(tmp_path, {"route.csv": b"", "summary.json": b""})
    assert [path.name for path, _ in files_to_open(tmp_path, STAGES)] == ["route.csv", "summary.json"]
