"""The state of a run folder."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.artifacts import (
    Record,
    State,
    open_run_folder,
    read_state,
    sha256,
)
from pipeline.stage import Stage
from tests.artifacts.saved import put

Make = dict[str, Callable[..., Any]]


def record(**values: Any) -> Record:
    """Make a record."""
    defaults = {"fingerprint": "f", "status": "done", "seconds": 1.5, "files": {}, "summary": {"kappa": None}}
    return Record.model_validate({**defaults, **values})


def test_state_round_trip(tmp_path: Path) -> None:
    """The next run reads the state that was written."""
    state = State(config_sha256="c", stages={Stage.ROUTE: record(files={"route.npz": "h"})})
    with open_run_folder(tmp_path) as folder:
        folder.change(state, {"route.npz": b"r"}, [], "name: a\n", {"name": "a"})
    assert read_state(tmp_path) == state


@pytest.mark.parametrize("content", [b"", b"{", b'{"stages": {"other": {}}}', b'{"stages": {"route": 1}}'])
def test_unreadable_state_is_no_results(tmp_path: Path, content: bytes) -> None:
    """A damaged state means that nothing is known, not a crash."""
    (tmp_path / "state.json").write_bytes(content)
    assert read_state(tmp_path) == State()


def test_no_folder_has_no_state(tmp_path: Path) -> None:
    """Without a run there is no state."""
    assert read_state(tmp_path / "none") is None


def test_damage_is_seen(tmp_path: Path) -> None:
    """Files that were edited or removed no longer fit their record."""
    put(tmp_path, {"a": b"abc", "b": b"abc"})
    known = record(files={name: sha256(tmp_path / "a") for name in ("a", "b", "c")})
    (tmp_path / "b").write_bytes(b"abd")
    assert known.damage(tmp_path) == ["b", "c"]
