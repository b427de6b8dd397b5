"""Files appear completely or not at all, and values become what JSON can hold."""

import errno
import json
import math
import os
import resource
import signal
from collections.abc import Callable
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
from pipeline.artifacts.files import staged, write_new
from pipeline.stage import Stage
from pipeline.status import Status
from tests.artifacts.saved import put


class TestWriting:
    """Files appear whole or not at all."""

    def test_content_and_no_leftovers(self, tmp_path: Path) -> None:
        """A written file holds its content, and nothing else is left beside it."""
        write_whole(tmp_path / "a.txt", b"new")
        assert (tmp_path / "a.txt").read_bytes() == b"new"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]

    def test_new_files_replace_nothing(self, tmp_path: Path) -> None:
        """A new file comes with its folders; what is there already, whatever it is, stays as it is."""
        write_new(tmp_path / "b" / "a.txt", b"new")
        (tmp_path / "link").symlink_to("nowhere")
        for path in (tmp_path / "b" / "a.txt", tmp_path / "link", tmp_path / "b"):
            with pytest.raises(FileExistsError) as caught:
                write_new(path, b"newer")
            assert str(caught.value.filename) == str(path)
        assert (tmp_path / "b" / "a.txt").read_bytes() == b"new"
        assert not (tmp_path / "nowhere").exists()

    def test_new_files_appear_whole(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """A new file has its name only when it is complete: a kill while it is written leaves nothing of that name."""
        write = Path.write_bytes

        def watch(self: Path, content: bytes) -> int:
            assert not (tmp_path / "a.yaml").exists()
            return write(self, content)

        monkeypatch.setattr(Path, "write_bytes", watch)
        write_new(tmp_path / "a.yaml", b"new")
        assert (tmp_path / "a.yaml").read_bytes() == b"new"
        assert [entry.name for entry in tmp_path.iterdir()] == ["a.yaml"]

    def test_new_files_where_there_are_no_links(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """A file that appears meanwhile is not replaced, with links or without."""

        def refuse(self: Path, target: Path) -> None:
            raise PermissionError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os.path, "lexists", lambda path: False)
        for name in ("linked", "not linked"):
            write_new(tmp_path / name, b"new")
            with pytest.raises(FileExistsError, match=name):
                write_new(tmp_path / name, b"newer")
            assert (tmp_path / name).read_bytes() == b"new"
            monkeypatch.setattr(Path, "hardlink_to", refuse)
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["linked", "not linked"]

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
        """What a killed process left under a temporary name is removed by the next run, and nothing else."""
        own = ["figures/.a.png.99.part", ".summary.json.0a1b.part", ".route.csv.12.part"]
        others = [".movie.mkv.part", "downloads/.route.csv.1.part", "figures/.a.txt.1.part", ".route.csv.part"]
        patterns = ("figures/*.png", "route.csv")
        put(tmp_path, dict.fromkeys([*own, *others], b"x"))
        with open_run_folder(tmp_path, patterns):
            assert [name for name in own if (tmp_path / name).exists()] == []
            assert [name for name in others if not (tmp_path / name).exists()] == []

    @pytest.mark.parametrize("make", [os.mkfifo, Path.mkdir, lambda path: path.symlink_to("elsewhere")])
    def test_only_regular_files_are_replaced(self, tmp_path: Path, make: Callable[[Path], None]) -> None:
        """What is something else stays what it is."""
        make(tmp_path / "a")
        before = (tmp_path / "a").lstat()
        with pytest.raises(OSError, match="not a regular file") as refused:
            write_whole(tmp_path / "a", b"new")
        assert refused.value.filename == str(tmp_path / "a")
        assert (tmp_path / "a").lstat() == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["a"]

    def test_errors_name_the_file(self, tmp_path: Path) -> None:
        """Neither a temporary name, nor none at all, as when the disk is full."""
        size = resource.getrlimit(resource.RLIMIT_FSIZE)
        ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, size[1]))
        try:
            with pytest.raises(OSError, match="too large") as refused:
                write_whole(tmp_path / "a.txt", b"x" * 2000)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, size)
            signal.signal(signal.SIGXFSZ, ignored)
        assert refused.value.filename == str(tmp_path / "a.txt")
        assert list(tmp_path.iterdir()) == []

    def test_long_names(self, tmp_path: Path) -> None:
        """A name may be as long as the system allows, although it is written under another one first."""
        name = "ä" * 127
        write_whole(tmp_path / name, b"new")
        assert (tmp_path / name).read_bytes() == b"new"

    def test_permissions_stay(self, tmp_path: Path) -> None:
        """A file that is replaced stays as private as it was."""
        (tmp_path / "a").touch(0o600)
        write_whole(tmp_path / "a", b"new")
        assert (tmp_path / "a").stat().st_mode & 0o777 == 0o600

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
