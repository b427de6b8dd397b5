"""Files of others in a folder that a run is to write to."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.artifacts import State, open_run_folder, read_state
from pipeline.artifacts.folder import require_usable
from pipeline.errors import UsageError
from tests.artifacts.saved import put

PATTERNS = ("route.csv", "figures/*.png", "failed/route.json")
SUMMARY = {"config_sha256": "c", "versions": {"gantry-tau": "0.1.0"}}
NAMES = [".lock", "state.json", "config.yaml", "summary.json", "route.csv", "figures", "failed", "superseded"]


def _link(path: Path) -> None:
    target = path.parent.parent / "elsewhere"
    target.mkdir(exist_ok=True)
    put(target, {"a": b"mine"})
    path.symlink_to(target if path.suffix == "" and path.name != ".lock" else target / "a")


def _run(folder: Path) -> None:
    with open_run_folder(folder, PATTERNS) as opened:
        opened.change(State(config_sha256="c"), {}, [], "name: a\n", SUMMARY)


def _look(folder: Path) -> dict[str, object]:
    """Give the content of files, and where links lead."""
    found = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*"))}
    return {
        name: path.readlink() if path.is_symlink() else path.read_bytes() if path.is_file() else path.lstat().st_mode
        for name, path in found.items()
        if name != "run/.lock" or path.is_symlink()
    }


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("make", [_link, os.mkfifo, lambda path: path.symlink_to("nowhere")])
@pytest.mark.parametrize("is_run", [True, False])
def test_only_files_and_folders_are_written_to(
    tmp_path: Path, name: str, make: Callable[[Path], None], is_run: bool
) -> None:
    """Links, dangling or not, and pipes under the names of a run's files and folders are refused, and stay."""
    folder = tmp_path / "run"
    if is_run:
        _run(folder)
        (folder / name).unlink(missing_ok=True)
    folder.mkdir(exist_ok=True)
    make(folder / name)
    before = _look(tmp_path)
    with pytest.raises(UsageError, match=r"a link|a pipe"), open_run_folder(folder, PATTERNS):
        pass
    assert _look(tmp_path) == before


def test_a_link_that_appears_late_is_not_written_through(tmp_path: Path) -> None:
    """It is looked for once more before anything changes."""
    (tmp_path / "elsewhere").mkdir()
    with open_run_folder(tmp_path / "run", PATTERNS) as opened:
        (tmp_path / "run" / "figures").symlink_to(tmp_path / "elsewhere")
        with pytest.raises(UsageError, match="figures is a link"):
            opened.change(State(), {"figures/a.png": b"", "route.csv": b""}, [], "", {})
        assert not (tmp_path / "run" / "route.csv").exists()
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.parametrize("content", [b'{"app": "not yours"}', b"", b'{"config_sha256": "", "stages": {}, "more": 1}'])
def test_a_state_of_another_program_protects_its_folder(tmp_path: Path, content: bytes) -> None:
    """It does not make a run folder of it."""
    put(tmp_path, {"state.json": content, "config.yaml": b"mine", "summary.json": b"{}"})
    before = _look(tmp_path)
    with pytest.raises(UsageError, match=r"not written by this program.*\n.*another folder with --out"):
        require_usable(tmp_path, PATTERNS)
    with pytest.raises(UsageError), open_run_folder(tmp_path, PATTERNS):
        pass
    assert _look(tmp_path) == before


def test_a_damaged_state_of_a_run_does_not(tmp_path: Path) -> None:
    """Where the summary shows that a run wrote it, nothing is known of earlier results, and what was there is kept."""
    _run(tmp_path)
    put(tmp_path, {"state.json": b"{", "figures/a.png": b"old"})
    with open_run_folder(tmp_path, PATTERNS) as opened:
        assert opened.damaged
        assert opened.state == State()
        opened.change(State(), {"figures/a.png": b"new"}, [], "name: b\n", SUMMARY)
    assert (tmp_path / "superseded" / "0001" / "state.json").read_bytes() == b"{"
    assert (tmp_path / "superseded" / "0001" / "figures" / "a.png").read_bytes() == b"old"
    assert read_state(tmp_path) == State()


@pytest.mark.parametrize("content", [b"", b"123", b"mine"])
def test_a_lock_of_another_program_is_left_alone(tmp_path: Path, content: bytes) -> None:
    """In a folder that is none of a run, whatever is in it; in one of a run, unless it is a process number."""
    put(tmp_path / "new", {".lock": content})
    with pytest.raises(UsageError, match="another program's"), open_run_folder(tmp_path / "new"):
        pass
    assert (tmp_path / "new" / ".lock").read_bytes() == content
    _run(tmp_path / "run")
    put(tmp_path / "run", {".lock": content})
    if content == b"mine":
        with pytest.raises(UsageError, match="another program's"), open_run_folder(tmp_path / "run"):
            pass
        assert (tmp_path / "run" / ".lock").read_bytes() == content
    else:
        with open_run_folder(tmp_path / "run"):
            pass


def test_what_is_in_the_way_is_kept(tmp_path: Path) -> None:
    """A file that no run has written is moved away before one of its name is; others stay."""
    _run(tmp_path)
    put(tmp_path, {"figures/a.png": b"mine", "figures/b.png": b"mine", "route.csv": b"mine"})
    with open_run_folder(tmp_path, PATTERNS) as opened:
        opened.change(State(), {"figures/a.png": b"new"}, [], "name: a\n", SUMMARY)
    assert (tmp_path / "figures" / "a.png").read_bytes() == b"new"
    assert (tmp_path / "superseded" / "0001" / "figures" / "a.png").read_bytes() == b"mine"
    assert (tmp_path / "figures" / "b.png").read_bytes() == (tmp_path / "route.csv").read_bytes() == b"mine"


def test_an_edited_configuration_is_kept(tmp_path: Path) -> None:
    """What somebody wrote into the configuration of a run is copied before it is written again."""
    _run(tmp_path)
    (tmp_path / "config.yaml").write_text("name: a  # mine\n")
    _run(tmp_path)
    assert (tmp_path / "superseded" / "0001" / "config.yaml").read_text() == "name: a  # mine\n"
    _run(tmp_path)
    assert not (tmp_path / "superseded" / "0002").exists()


def test_numbers_of_superseded_results(tmp_path: Path) -> None:
    """Names that are no numbers of this program do not count."""
    _run(tmp_path)
    for name in ("9" * 250, "٣", "0003", "x"):
        (tmp_path / "superseded" / name).mkdir(parents=True)
    put(tmp_path, {"route.csv": b"1"})
    with open_run_folder(tmp_path, PATTERNS) as opened:
        opened.change(State(), {}, ["route.csv"], "name: a\n", SUMMARY)
    assert (tmp_path / "superseded" / "0004" / "route.csv").exists()


def test_a_refused_folder_is_not_made(tmp_path: Path) -> None:
    """A link that leads nowhere is no folder, and gets no target."""
    (tmp_path / "out").symlink_to("nowhere")
    with pytest.raises(UsageError, match="leads nowhere"), open_run_folder(tmp_path / "out"):
        pass
    assert not (tmp_path / "nowhere").exists()
    shutil.rmtree(tmp_path)
