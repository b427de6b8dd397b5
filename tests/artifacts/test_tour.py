"""The folder of a tour."""

import json
from pathlib import Path

import pytest

from pipeline.artifacts.tour import open_tour_folder, read_tour
from pipeline.errors import LockedError, UsageError


def test_a_tour_is_read_once_it_is_finished(tmp_path: Path):
    """Until then the folder is one of a tour, but of none that is known."""
    with open_tour_folder(tmp_path / "t") as folder:
        with pytest.raises(UsageError, match="no finished tour"):
            read_tour(folder.path)
        folder.write({"tour.json": json.dumps({"legs": []}).encode()})
        assert read_tour(folder.path) == {"legs": []}
        assert folder.leg("start--pose-1") == tmp_path / "t" / "legs" / "start--pose-1"


def test_one_process_drives_at_a_time(tmp_path: Path):
    """Another one is refused, and the folder is taken up again afterwards."""
    with open_tour_folder(tmp_path / "t"), pytest.raises(LockedError), open_tour_folder(tmp_path / "t"):
        pass
    with open_tour_folder(tmp_path / "t"):
        pass


@pytest.mark.parametrize("content", ['{"stations": 3}', "[]", "nothing"])
def test_another_programs_record_is_kept(tmp_path: Path, content: str):
    """A file of that name that says something else."""
    (tmp_path / "tour.json").write_text(content)
    with pytest.raises(UsageError, match="no tour"), open_tour_folder(tmp_path):
        pass
    assert (tmp_path / "tour.json").read_text() == content
