"""Whatever is in a folder: a command changes only the files that it writes itself, and nothing through a link."""

import os
import re
import socket
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import Config
from pipeline.config.file import dump_config
from tests.cli.calls import invoke
from tests.fuzzing import fuzz
from tests.run.fake_stages import FakeStages
from tests.run.folders import BOOKS, RESULT_FILES

NAMES = [
    "notes.txt",
    ".movie.mkv.part",
    ".route.csv.part",
    "downloads/.route.csv.12.part",
    "figures/mine.png",
    "figures/route.png",
    "figures",
    "failed",
    "failed/notes.txt",
    "failed/route.json",
    "superseded",
    "superseded/0001",
    "superseded/mine",
    ".lock",
    "state.json",
    "config.yaml",
    "summary.json",
    "route.csv",
    "trajectory.csv",
    "report.html",
    "../.regions",
    "../.regions/mine.npz",
]
"""Names of files of a run, names like them, and others."""
OWN = {*RESULT_FILES, *BOOKS, "failed/route.json"}


def _file(path: Path) -> None:
    path.write_bytes(b"mine: " + path.name.encode())


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as listening:
        before = Path.cwd()
        os.chdir(path.parent)  # an address is short
        try:
            listening.bind(path.name)
        finally:
            os.chdir(before)


def _device(path: Path) -> None:
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except PermissionError:
        os.mkfifo(path)


KINDS: dict[str, Callable[[Path], None]] = {
    "file": _file,
    "folder": Path.mkdir,
    "link to a file": lambda path: path.symlink_to(path.parents[len(path.parts) - 4] / "elsewhere" / "file"),
    "link to a folder": lambda path: path.symlink_to(path.parents[len(path.parts) - 4] / "elsewhere"),
    "link to nothing": lambda path: path.symlink_to("nowhere"),
    "loop": lambda path: path.symlink_to(path.name),
    "pipe": os.mkfifo,
    "socket": _socket,
    "device": _device,
}
COMMANDS = {
    "run": ("run", "machine.yaml", "--out", "out/run"),
    "run again": ("run", "machine.yaml", "--out", "out/run", "--force"),
    "route": ("route", "machine.yaml", "--out", "out/run"),
    "alternatives": ("route", "machine.yaml", "--out", "out/run", "--alternatives", "2"),
    "report": ("report", "out/run"),
    "report elsewhere": ("report", "out/run", "--output", "page.html"),
    "export": ("export", "out/run", "--output", "out.csv"),
    "simulate": ("simulate-measurement", "out/run", "--output", "seen.csv"),
    "compare": ("compare", "out/run", "--no-timing"),
    "check": ("certify", "--check", "out/run"),
}


def _plant(path: Path, kind: str) -> bool:
    """Put something at a path, in the place of a file, but not of a folder; return whether it is there now."""
    parents = [parent for parent in path.parents if os.path.lexists(parent)]
    if path.is_dir() or any(parent.is_symlink() or not parent.is_dir() for parent in parents):
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    KINDS[kind](path)
    return True


def _look(path: Path) -> object:
    """Give what is at a path: its kind, identity and content."""
    if not os.path.lexists(path):
        return None
    status = path.lstat()
    if stat.S_ISLNK(status.st_mode):
        return path.readlink()
    if stat.S_ISDIR(status.st_mode):
        return stat.S_IFDIR
    content = path.read_bytes() if stat.S_ISREG(status.st_mode) else status.st_rdev
    return status.st_mode, status.st_ino, status.st_nlink, status.st_mtime_ns, content


def _everything(folder: Path) -> dict[Path, object]:
    paths = (Path(root) / name for root, folders, files in os.walk(folder) for name in (*folders, *files))
    return {path: _look(path) for path in paths}


def _is_of_run(path: Path) -> bool:
    """Check whether a path is that of a run, or of a table beside it."""
    name = path.relative_to(Path.cwd()).as_posix()
    return re.fullmatch(r"out/run(-2)?/.*|out/\.regions/[0-9a-f]{64}\.npz", name) is not None


def _is_kept(path: Path, run: Path) -> bool:
    """Check whether the content of a file that somebody put into the place of one of a run's is still there."""
    name = path.relative_to(run).as_posix()
    copies = [path, *run.glob(f"superseded/*/{name}")]
    return any(copy.is_file() and copy.read_bytes() == b"mine: " + path.name.encode() for copy in copies)


@fuzz(12)
@given(
    is_run=st.booleans(),
    planted=st.dictionaries(st.sampled_from(NAMES), st.sampled_from(sorted(KINDS)), max_size=4),
    commands=st.lists(st.sampled_from(sorted(COMMANDS)), min_size=1, max_size=3),
)
def test_files_of_others_stay(fast_config: Config, is_run: bool, planted: dict[str, str], commands: list[str]) -> None:
    """In a folder of a run, and in any other, whatever the commands come to."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            _try(fast_config, is_run, planted, commands)
        finally:
            os.chdir(before)


def _try(fast_config: Config, is_run: bool, planted: dict[str, str], commands: list[str]) -> None:
    stages = FakeStages(caches=True)
    Path("machine.yaml").write_text(dump_config(fast_config))
    (Path("elsewhere") / "figures").mkdir(parents=True)
    for name in ("file", "mine.png", "figures/route.png", "route.csv", "0001", ".a.npz.1.part"):
        _file(Path("elsewhere") / name)
    run = Path.cwd() / "out" / "run"
    run.mkdir(parents=True)
    if is_run:
        assert invoke(*COMMANDS["run"], specs=stages.specs).exit_code == 0
    paths = {name: Path(os.path.normpath(run / name)) for name in sorted(planted)}
    there = {name: path for name, path in paths.items() if _plant(path, planted[name])}
    elsewhere = _everything(Path("elsewhere"))
    foreign = {path: look for path, look in _everything(Path.cwd()).items() if not (is_run and _is_of_run(path))}
    replaceable = {path for name, path in there.items() if is_run and planted[name] == "file" and name in OWN}
    foreign |= {path: _look(path) for path in there.values() if path not in replaceable}
    for command in commands:
        assert invoke(*COMMANDS[command], specs=stages.specs).exit_code in (0, 1, 2)
    assert _everything(Path("elsewhere")) == elsewhere
    assert {path: _look(path) for path in foreign} == foreign
    assert [path for path in replaceable - {run / "summary.json"} if not _is_kept(path, run)] == []
