"""The state of a run folder."""

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from pipeline.artifacts import (
    Record,
    State,
    open_run_folder,
    read_state,
    sha256,
)
from pipeline.artifacts.state import state_bytes
from pipeline.errors import UsageError
from pipeline.stage import Stage
from tests.artifacts.saved import put
from tests.artifacts.test_files import json_values
from tests.fuzzing import fuzz

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


GOOD = state_bytes(State(config_sha256="c", stages={Stage.ROUTE: record(files={"route.npz": "h"})}))


def edited(**changes: Any) -> bytes:
    """Change keys of the state's file, or of its record."""
    data = json.loads(GOOD)
    data["stages"]["route"] |= {key: value for key, value in changes.items() if key in data["stages"]["route"]}
    return json.dumps(data | {key: value for key, value in changes.items() if key in data}).encode()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b"[]",
        b"{}",
        b'{"app": "not yours"}',
        b"[" * 100_000,
        b" " * 2**25,
        b'{"config_sha256": "", "stages": {"other": {}}}',
        b'{"config_sha256": "", "stages": {"route": 1}}',
        GOOD[:-20],
        edited(seconds="1.5"),
        edited(seconds=-1.0),
        edited(seconds=float("nan")),
        edited(status="perhaps"),
        edited(files={"../a": "h"}),
        edited(files={"/etc/passwd": "h"}),
        edited(files=["route.npz"]),
        edited(summary=None),
        edited(summary={"kappa": 1.0}),
        edited(summary={"kappa": [[[]]]}),
        GOOD.replace(b'"kappa": null', b'"kappa": ' + b"9" * 20_000),
        GOOD.replace(b'"kappa": null', b'"kappa": ' + b"[" * 150 + b"]" * 150),
        edited(fingerprint="g"),
        edited(config_sha256="d"),
        edited(config_sha256=None),
        edited(seal="0"),
        edited(stages={}),
    ],
)
def test_a_state_that_is_not_as_it_was_written_is_refused(tmp_path: Path, content: bytes) -> None:
    """Damaged, edited, or another program's: it is refused with the reason, and never used in part."""
    (tmp_path / "state.json").write_bytes(content)
    with pytest.raises(UsageError, match=r"state\.json is damaged, or was not written by this program: .+"):
        read_state(tmp_path)
    (tmp_path / "state.json").write_bytes(GOOD)
    assert read_state(tmp_path) is not None


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    """What is not a regular file is refused as what it is."""
    os.mkfifo(tmp_path / "state.json")
    with pytest.raises(UsageError, match="it is a pipe, not a regular file"):
        read_state(tmp_path)


def test_states_of_earlier_versions_are_read_but_not_taken_up(tmp_path: Path) -> None:
    """Without a seal nobody knows what results were made from: fingerprints match nothing."""
    data = json.loads(GOOD)
    del data["seal"], data["stages"]["route"]["sizes"]
    (tmp_path / "state.json").write_text(json.dumps(data))
    state = read_state(tmp_path)
    assert state is not None
    assert state.config_sha256 == "c"
    assert state.stages[Stage.ROUTE] == record(files={"route.npz": "h"}, fingerprint="")


@fuzz(100)
@given(json_values)
def test_whatever_json_it_holds_is_read_or_refused(value: Any) -> None:
    """No JSON makes reading fail in any other way."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "state.json").write_text(json.dumps(value))
        with pytest.raises(UsageError):
            read_state(Path(folder))


def test_no_folder_has_no_state(tmp_path: Path) -> None:
    """Without a run there is no state."""
    assert read_state(tmp_path / "none") is None


def test_damage_is_seen(tmp_path: Path) -> None:
    """Files that were edited or removed no longer fit their record."""
    put(tmp_path, {"a": b"abc", "b": b"abc"})
    known = record(files={name: sha256(tmp_path / "a") for name in ("a", "b", "c")})
    (tmp_path / "b").write_bytes(b"abd")
    assert known.damage(tmp_path) == ["b", "c"]
