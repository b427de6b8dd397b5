"""The run folder: locked while a run writes to it, changed in one step, with old results kept."""

import contextlib
import fcntl
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pipeline.artifacts.files import json_bytes, remove_partial, staged, write_whole
from pipeline.artifacts.layout import CONFIG, LOCK, STATE, SUMMARY, SUPERSEDED, existing_files
from pipeline.artifacts.state import State, read_state
from pipeline.config import Config
from pipeline.config.file import config_sha256, load_config, read_yaml
from pipeline.errors import UsageError


class RunFolder:
    """A folder of results, opened by `open_run_folder` for one run at a time.

    Attributes
    ----------
    path : Path
        The folder.
    state : State
        What its results were made from; an unreadable state counts as no results.
    """

    def __init__(self, path: Path, state: State) -> None:
        self.path = path
        self.state = state
        self._attic: Path | None = None

    def change(
        self,
        state: State,
        files: Mapping[str, bytes],
        superseded: Iterable[str],
        config_yaml: str,
        summary: Mapping[str, object],
    ) -> None:
        """Add new files to the folder, move superseded ones away, and record the new state.

        All new files are complete on disk before any old file moves. If the process is killed in between, the files
        that moved are among the superseded ones, and the state no longer matches: the stage counts as not done.
        """
        bookkeeping = {
            CONFIG: config_yaml.encode(),
            SUMMARY: json_bytes(summary),
            STATE: json_bytes(state.model_dump(mode="json")),
        }
        unchanged = {name for name in superseded if name in files and self._holds(name, files[name])}
        new = {name: content for name, content in files.items() if name not in unchanged}
        with staged(self.path, {**new, **bookkeeping}) as place:
            self._move_away([name for name in superseded if name not in unchanged])
            place()
        self.state = state

    def _holds(self, name: str, content: bytes) -> bool:
        return (self.path / name).read_bytes() == content

    def _move_away(self, names: list[str]) -> None:
        """Move files to this run's folder of superseded ones, with copies of the configuration, summary and state."""
        if not names:
            return
        if self._attic is None:
            self._attic = _next_numbered(self.path / SUPERSEDED)
            for name in (CONFIG, SUMMARY, STATE):
                with contextlib.suppress(FileNotFoundError):
                    shutil.copy2(self.path / name, self._attic / name)
        for name in names:
            target = self._attic / name
            target.parent.mkdir(parents=True, exist_ok=True)
            (self.path / name).replace(target)
            _remove_if_empty((self.path / name).parent)


@contextlib.contextmanager
def open_run_folder(path: Path, reserved: Iterable[str] = ()) -> Iterator[RunFolder]:
    """Create or open a run folder, and lock it against other runs until the end.

    The operating system holds the lock: it is released when the process ends, however it ends.

    Parameters
    ----------
    reserved : iterable of str
        Patterns of result files, which must not exist in a folder that is not a run folder yet.

    Raises
    ------
    UsageError
        When another run is writing there, or files with the names of results exist in what is not a run folder.
    """
    if path.exists() and not path.is_dir():
        raise UsageError(f"{path} is a file; --out needs a folder")
    if not (path / STATE).exists() and (foreign := existing_files(path, (CONFIG, SUMMARY, *reserved))):
        raise UsageError(
            f"{path} already holds {', '.join(foreign[:3])}, but is not a run folder (it has no {STATE}): nothing "
            "was changed.\n  What to change: give another folder with --out, or move these files away."
        )
    path.mkdir(parents=True, exist_ok=True)
    with _locked(path):
        remove_partial(path)
        state = read_state(path)
        if state is None:
            state = State()
            write_whole(path / STATE, json_bytes(state.model_dump(mode="json")))
        yield RunFolder(path, state)


def read_run_folder(path: Path) -> tuple[Config, State]:
    """Read the configuration and state of a run folder.

    Raises
    ------
    UsageError
        When it is not a run folder, or its configuration was changed.
    """
    state = read_state(path) if path.is_dir() else None
    if state is None or not state.config_sha256:
        what = "is not a run folder" if path.exists() else "does not exist"
        raise UsageError(
            f"{path} {what}.\n  What to change: give the folder a run has written to, such as results/agder."
        )
    config = load_config(path / CONFIG)
    # A key that is newer than the run has its default, and is not in the file.
    if state.config_sha256 not in (config_sha256(config), config_sha256(read_yaml(path / CONFIG))):
        raise UsageError(
            f"{path / CONFIG} was changed after the run: the results do not belong to it.\n"
            f"  What to change: run it, with gantry-tau run {path / CONFIG} --out {path}."
        )
    return config, state


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    # Opened for appending: the process number of another run must stay until the lock is known to be free.
    with (path / LOCK).open("a+") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            raise UsageError(
                f"another run (process {lock.read().strip() or 'unknown'}) is writing to {path}.\n"
                "  What to change: wait until it ends, or give another folder with --out."
            ) from None
        lock.truncate(0)
        lock.write(str(os.getpid()))
        lock.flush()
        yield


def _next_numbered(attic: Path) -> Path:
    taken = [int(entry.name) for entry in attic.glob("*") if entry.name.isdecimal()]
    folder = attic / f"{max(taken, default=0) + 1:04d}"
    folder.mkdir(parents=True)
    return folder


def _remove_if_empty(folder: Path) -> None:
    if not any(folder.iterdir()):
        folder.rmdir()
