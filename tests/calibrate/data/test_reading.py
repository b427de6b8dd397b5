"""Files of static poses."""

import hashlib
from pathlib import Path

import numpy as np
import pytest

from pipeline.calibrate.data.reading import read_poses
from pipeline.errors import UsageError

HEADER = "q1_m,q2_m,q3_m,q4_m,q5_m,x1_m,y1_m,z1_m,x2_m,y2_m,z2_m"


def written(path: Path, *rows: str, header: str = HEADER) -> Path:
    """Write a table."""
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_rows_of_several_files_follow_each_other(tmp_path: Path):
    """Points are where they were seen, NaN where a cell is empty, and every row knows its file and line."""
    one = written(tmp_path / "one.csv", "1,2,3,4,5,.1,.2,.3,.4,.5,.6", "1,2,3,4,6,,,,.4,.5,.6")
    two = written(tmp_path / "two.csv", "# second day", "1,2,3,4,7,.1,.2,---,NaN,,")
    files = [one, two]
    poses, read = read_poses(files, 2)
    assert poses.q_m[:, 4].tolist() == [5.0, 6.0, 7.0]
    assert poses.is_seen.tolist() == [[True, True], [False, True], [False, False]]
    np.testing.assert_array_equal(poses.seen_m[0], [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    assert [poses.place(row) for row in range(3)] == [f"{one}, line 2", f"{one}, line 3", f"{two}, line 3"]
    assert poses.at(np.array([2])).place(0) == f"{two}, line 3"
    assert [len(each.account.row_lines) for each in read] == [2, 1]
    assert [each.sha256 for each in read] == [hashlib.sha256(file.read_bytes()).hexdigest() for file in files]


def test_more_reflectors_than_places_are_refused(tmp_path: Path):
    """Columns of a reflector whose place is not given are not dropped silently."""
    file = written(tmp_path / "one.csv", "1,2,3,4,5,.1,.2,.3,.4,.5,.6")
    with pytest.raises(UsageError, match=r"columns of a reflector 2.*\n.*--reflector-2"):
        read_poses([file], 1)
    with pytest.raises(UsageError, match="x3_m"):
        read_poses([file], 3)


def test_a_gap_in_an_encoder_skips_the_row(tmp_path: Path):
    """A pose whose encoders are not known is of no use, and counted."""
    file = written(tmp_path / "one.csv", "1,2,,4,5,.1,.2,.3,.4,.5,.6", "1,2,3,4,5,.1,.2,.3,.4,.5,.6")
    poses, read = read_poses([file], 2)
    assert len(poses) == 1
    assert read[0].account.gap_count == 1
