"""Run folders are cleared whole, and only where nobody needs them."""

from pathlib import Path

import pytest

from pipeline.artifacts.lock import locked
from pipeline.study.config import Keep
from pipeline.study.rows import Ending, Row
from pipeline.study.worker.clear import clear_run
from pipeline.study.worker.task import keep_row


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Make a run folder with the rows of a run that is done and of one without a result."""
    (tmp_path / "figures").mkdir()
    for name in (".lock", "state.json", "route.npz", "figures/x.png", "twin-a.json"):
        (tmp_path / name).touch()
    for key, ending in (("a", Ending.DONE), ("b", Ending.NO_SOLUTION)):
        keep_row({"folder": str(tmp_path), "key": key}, Row(key, ending.value))
    return tmp_path


def names(folder: Path) -> list[str]:
    """List what is in a folder."""
    return sorted(path.name for path in folder.iterdir())


def test_rows_stay(folder: Path) -> None:
    """And nothing else; clearing once more changes nothing, and neither does it where there is no folder."""
    for _ in range(2):
        clear_run(folder, Keep.NONE)
        assert names(folder) == ["row-a.json", "row-b.json"]
    clear_run(folder / "none", Keep.NONE)
    assert not (folder / "none").exists()


def test_what_is_to_be_kept_is(folder: Path) -> None:
    """A folder that a run without a result has, too, is one of a failed run."""
    before = names(folder)
    for keep in (Keep.ALL, Keep.FAILED):
        clear_run(folder, keep)
        assert names(folder) == before
    (folder / "row-b.json").unlink()
    clear_run(folder, Keep.FAILED)
    assert names(folder) == ["row-a.json"]


def test_a_folder_in_use_is_left(folder: Path) -> None:
    """Whole: whoever holds its lock finds all that was there."""
    before = names(folder)
    with locked(folder, new=False):
        clear_run(folder, Keep.NONE)
    assert names(folder) == before


def test_a_folder_that_is_half_cleared_is_a_run_folder(folder: Path) -> None:
    """After a kill at any moment it can be run in, and be cleared."""
    (folder / ".lock").unlink()
    with locked(folder, new=False):
        pass
    clear_run(folder, Keep.NONE)
    assert names(folder) == ["row-a.json", "row-b.json"]
