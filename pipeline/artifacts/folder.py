"""The run folder: locked while it is written to, changed all at once, and nothing in it ever lost."""

import contextlib
import fcntl
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pipeline.artifacts.files import json_bytes, parked, remove_partial, write_whole
from pipeline.artifacts.layout import CONFIG, LOCK, STATE, SUMMARY, SUPERSEDED, foreign_files
from pipeline.artifacts.state import State, read_state
from pipeline.config import Config
from pipeline.config.file import config_sha256, load_config
from pipeline.errors import UsageError


class RunFolder:
    """A folder of results, opened by `open_run_folder` for one run at a time.

    Attributes
    ----------
    path : Path
        Where it is.
    state : State
        What its results were made from; unreadable state counts as no results.
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
        """Put new files into the folder, move superseded ones away, and remember the new state.

        Everything new is complete on disk before anything old moves. Where that is cut short, what moved is
        among the superseded files and the state no longer fits, so that the stage counts as not done.
        """
        bookkeeping = {
            CONFIG: config_yaml.encode(),
            SUMMARY: json_bytes(summary),
            STATE: json_bytes(state.model_dump(mode="json")),
        }
        unchanged = {name for name in superseded if name in files and self._holds(name, files[name])}
        new = {name: content for name, content in files.items() if name not in unchanged}
        with parked(self.path, {**new, **bookkeeping}) as place:
            self._move_away([name for name in superseded if name not in unchanged])
            place()
        self.state = state

    def _holds(self, name: str, content: bytes) -> bool:
        return (self.path / name).read_bytes() == content

    def _move_away(self, names: list[str]) -> None:
        """Move files into this run's folder of superseded ones, with copies of what says where they are from."""
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
def open_run_folder(path: Path) -> Iterator[RunFolder]:
    """Make or open a run folder and keep other runs out of it until the end.

    The lock is the operating system's own: it goes with the process, however that ends.

    Raises
    ------
    UsageError
        When another run is at work there, or the folder holds files of ours without being a run folder.
    """
    if path.exists() and not path.is_dir():
        raise UsageError(f"{path} is a file; --out needs a folder")
    if not (path / STATE).exists() and (foreign := foreign_files(path)):
        raise UsageError(
            f"{path} already holds {', '.join(foreign[:3])}, but is no run folder (it has no {STATE}): nothing "
            "was touched.\n  What to change: give another folder with --out, or move these files away."
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
    """Read the configuration and state of a run folder, to look at its results.

    Raises
    ------
    UsageError
        When it is no run folder, or its configuration was changed.
    """
    state = read_state(path) if path.is_dir() else None
    if state is None or not state.config_sha256:
        what = "is no run folder" if path.exists() else "does not exist"
        raise UsageError(
            f"{path} {what}.\n  What to change: name the folder a run has written to, such as results/agder."
        )
    config = load_config(path / CONFIG)
    if config_sha256(config) != state.config_sha256:
        raise UsageError(
            f"{path / CONFIG} was changed after the run: the results do not belong to it.\n"
            f"  What to change: run it, with gantry-tau run {path / CONFIG} --out {path}."
        )
    return config, state


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    # Opened for appending: the other run's number must not be lost before the lock is known to be free.
    with (path / LOCK).open("a+") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            raise UsageError(
                f"another run (process {lock.read().strip() or 'unknown'}) is at work in {path}.\n"
                "  What to change: wait for it to end, or give another folder with --out."
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
