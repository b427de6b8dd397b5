"""Files appear completely or not at all, and values become what JSON can hold."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.artifacts import (
    json_bytes,
    jsonable,
    open_run_folder,
    sha256,
    write_whole,
)
from pipeline.artifacts.files import staged
from pipeline.stage import Stage
from pipeline.status import Status


class TestWriting:
    """Files appear whole or not at all."""

    def test_content_and_no_leftovers(self, tmp_path: Path) -> None:
        """A written file holds its content, and nothing else is left beside it."""
        write_whole(tmp_path / "a.txt", b"new")
        assert (tmp_path / "a.txt").read_bytes() == b"new"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]

    @pytest.mark.parametrize("moment", ["write_bytes", "replace"])
    def test_crash_leaves_old_file(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: str) -> None:
        """Whatever goes wrong while a file is replaced, the old one stays and no half of the new one."""
        target = tmp_path / "a.txt"
        target.write_bytes(b"old")

        def crash(self: Path, *_: object) -> None:
            if moment == "write_bytes":
                with self.open("wb") as file:
                    file.write(b"n")
            raise KeyboardInterrupt

        monkeypatch.setattr(Path, moment, crash)
        with pytest.raises(KeyboardInterrupt):
            write_whole(target, b"new")
        monkeypatch.undo()
        assert target.read_bytes() == b"old"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]

    def test_several_files_are_complete_before_the_first_is_placed(self, tmp_path: Path) -> None:
        """Files that belong together are all written before any of them is seen."""
        with staged(tmp_path, {"a": b"1", "deep/b": b"2"}) as place:
            assert not (tmp_path / "a").exists()
            assert len(list(tmp_path.rglob(".*.part"))) == 2
            place()
            assert (tmp_path / "deep" / "b").read_bytes() == b"2"
        assert not list(tmp_path.rglob("*.part"))

    def test_killed_writer_is_cleaned_up_after(self, tmp_path: Path) -> None:
        """What a killed process left under a temporary name is removed by the next run."""
        (tmp_path / "figures").mkdir()
        (tmp_path / "figures" / ".a.png.99.part").write_bytes(b"x")
        with open_run_folder(tmp_path):
            assert not list(tmp_path.rglob("*.part"))

    def test_permissions_follow_umask(self, tmp_path: Path) -> None:
        """Results are as readable as any file the user makes."""
        write_whole(tmp_path / "a", b"")
        (tmp_path / "b").touch()
        assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode

    def test_hash(self, tmp_path: Path) -> None:
        """The hash of a file is that of its content; no file has none."""
        (tmp_path / "a").write_bytes(b"abc")
        assert sha256(tmp_path / "a") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        assert sha256(tmp_path / "b") is None
        assert sha256(tmp_path) is None


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


class TestJsonable:
    """Every value becomes what JSON can hold."""

    @settings(max_examples=50)
    @given(json_values)
    def test_round_trip(self, value: Any) -> None:
        """Plain values survive JSON, NaN and infinities as null."""

        def expected(item: Any) -> Any:
            if isinstance(item, float) and not math.isfinite(item):
                return None
            if isinstance(item, list):
                return [expected(each) for each in item]
            if isinstance(item, dict):
                return {key: expected(each) for key, each in item.items()}
            return item

        assert json.loads(json_bytes(value)) == expected(value)

    def test_numpy_and_other_types(self) -> None:
        """Arrays become lists, numpy's numbers numbers, dataclasses dictionaries, the unknown its text."""

        @dataclass
        class Pair:
            first: float
            second: object

        value = {
            Stage.ROUTE: np.array([[1.0, np.inf]]),
            "number": np.float64(2.0),
            "count": np.int64(3),
            "flag": np.bool_(True),
            "pair": Pair(np.nan, (1, {2})),
            "status": Status.OPTIMAL,
            "path": Path("a"),
        }
        assert jsonable(value) == {
            "route": [[1.0, None]],
            "number": 2.0,
            "count": 3,
            "flag": True,
            "pair": {"first": None, "second": [1, [2]]},
            "status": "optimal",
            "path": "a",
        }
