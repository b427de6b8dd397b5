"""Regions of grid and gates cached beside the run folders."""

import hashlib
import os
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from pipeline.artifacts import region_cache
from pipeline.artifacts.region_cache import KEPT, keep_grid, load_grid
from pipeline.machine import build_machine


@pytest.fixture(scope="module")
def table(make, quick_config):
    """Make a table of a few regions."""
    return make["regions"](build_machine(quick_config.machine), 4)


def _assert_same(one, other):
    for field in fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)


def _key(name: str) -> str:
    """Make a key as the hash of something is one."""
    return hashlib.sha256(name.encode()).hexdigest()


def _kept(runs: Path) -> list[str]:
    return sorted(path.name for path in (runs / region_cache.FOLDER).iterdir())


def test_what_is_kept_comes_back_exactly(tmp_path, table):
    """Every column, bit for bit; another key has nothing."""
    keep_grid(tmp_path, "a", table)
    _assert_same(load_grid(tmp_path, "a"), table)
    assert load_grid(tmp_path, "b") is None
    assert _kept(tmp_path) == ["a.npz"]


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04 and no more", "cut", "flipped", "another"])
def test_a_damaged_file_is_as_good_as_none(tmp_path, table, damage):
    """Empty, cut short, changed in one bit, or an archive of something else: the table is computed again."""
    keep_grid(tmp_path, "a", table)
    path = tmp_path / region_cache.FOLDER / "a.npz"
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) // 2]
    elif damage == "flipped":
        content[content.find(np.float64(table.kappa[1]).tobytes())] ^= 1
    elif damage == "another":
        with path.open("wb") as file:
            np.savez(file, kappa=table.kappa)
        content = path.read_bytes()
    else:
        content = damage
    path.write_bytes(content)
    assert load_grid(tmp_path, "a") is None
    keep_grid(tmp_path, "a", table)
    _assert_same(load_grid(tmp_path, "a"), table)


def test_the_tables_used_last_stay(tmp_path, table):
    """What was read counts as used; leftovers of killed processes grow old like tables do."""
    for age in range(KEPT):
        keep_grid(tmp_path, _key(f"{age}"), table)
        os.utime(tmp_path / region_cache.FOLDER / f"{_key(f'{age}')}.npz", (1000 + age, 1000 + age))
    leftover = tmp_path / region_cache.FOLDER / f".{_key('x')[:40]}.1.part"
    leftover.write_bytes(b"half")
    os.utime(leftover, (1, 1))
    assert load_grid(tmp_path, _key("0")) is not None
    keep_grid(tmp_path, _key("new"), table)
    kept = ["new", "0", *(f"{age}" for age in range(2, KEPT))]
    assert _kept(tmp_path) == sorted(f"{_key(name)}.npz" for name in kept)


def test_files_of_others_stay(tmp_path, table):
    """However old, and however many: only tables are dropped."""
    folder = tmp_path / region_cache.FOLDER
    folder.mkdir()
    names = [*(f"mine{number}.npz" for number in range(KEPT)), ".movie.mkv.part", "notes.txt"]
    for name in names:
        (folder / name).write_text("mine")
        os.utime(folder / name, (1, 1))
    (folder / f"{_key('link')}.npz").symlink_to("notes.txt")
    keep_grid(tmp_path, _key("a"), table)
    keep_grid(tmp_path, _key("link"), table)
    assert load_grid(tmp_path, _key("link")) is None
    assert {(folder / name).read_text() for name in names} == {"mine"}
    assert len(_kept(tmp_path)) == len(names) + 2


def test_nothing_is_kept_through_a_link(tmp_path, table):
    """A link in the place of the folder: its target is left alone."""
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / region_cache.FOLDER).symlink_to("elsewhere")
    keep_grid(tmp_path, _key("a"), table)
    assert list((tmp_path / "elsewhere").iterdir()) == []
    assert load_grid(tmp_path, _key("a")) is None


def test_a_pipe_is_not_waited_for(tmp_path, table):
    """What is not a regular file is neither read nor replaced."""
    folder = tmp_path / region_cache.FOLDER
    folder.mkdir()
    os.mkfifo(folder / f"{_key('a')}.npz")
    assert load_grid(tmp_path, _key("a")) is None
    keep_grid(tmp_path, _key("a"), table)
    assert (folder / f"{_key('a')}.npz").is_fifo()


def test_a_run_goes_on_where_nothing_can_be_kept(tmp_path, table):
    """A file in the place of the folder: nothing is kept, and nothing raised."""
    (tmp_path / region_cache.FOLDER).write_text("in the way")
    keep_grid(tmp_path, "a", table)
    assert load_grid(tmp_path, "a") is None
    assert (tmp_path / region_cache.FOLDER).read_text() == "in the way"
