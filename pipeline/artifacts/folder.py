"""The run folder: locked while a run writes to it, changed in one step, with old results kept."""

import contextlib
import hashlib
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from pipeline.artifacts.files import json_bytes, remove_partial, sha256, staged, write_whole
from pipeline.artifacts.foreign import refuse_foreign, refuse_foreign_state, refuse_links, refuse_no_folder
from pipeline.artifacts.layout import BOOKS, CONFIG, LOCK, STATE, SUMMARY, SUPERSEDED
from pipeline.artifacts.lock import locked
from pipeline.artifacts.state import State, read_state, state_bytes
from pipeline.config import Config
from pipeline.config.file import NOT_COUNTED, config_sha256, load_config, read_yaml
from pipeline.errors import UsageError
from pipeline.regular_file import open_regular_file
from pipeline.solvers.interrupts import interrupts_noted

_NUMBER = re.compile(r"[0-9]{1,9}")
"""Names of folders of superseded results."""
_UNKNOWN = State()
"""Stands for a state that is damaged."""
_MOST_CONFIG_BYTES = 2**24
"""Size of the largest configuration of a run that is read."""


class RunFolder:
    """A folder of results, opened by `open_run_folder` for one run at a time.

    Attributes
    ----------
    path : Path
        The folder.
    state : State
        What its results were made from; of a damaged state nothing is known.
    damaged : bool
        The state was damaged: which files are those of earlier runs shows in their names alone.
    """

    def __init__(self, path: Path, state: State, damaged: bool = False) -> None:
        self.path = path
        self.state = state
        self.damaged = damaged
        self._attic: Path | None = None
        self._moved: list[str] = []

    @property
    def superseded(self) -> tuple[Path, tuple[str, ...]] | None:
        """Where files of earlier runs were moved to, and those that have no successor; None if there are none."""
        gone = tuple(name for name in dict.fromkeys(self._moved) if not (self.path / name).exists())
        return (self._attic, gone) if self._attic is not None and gone else None

    def change(
        self,
        state: State,
        files: Mapping[str, bytes],
        superseded: Iterable[str],
        config_yaml: str,
        summary: Mapping[str, object],
    ) -> None:
        """Add new files to the folder, move superseded ones away, and record the new state.

        What is overwritten and was not written by a run moves away, too. All new files are complete on disk before any
        old file moves, and Ctrl-C waits. If the process is killed in between, the files that moved are among the
        superseded ones, and the state no longer matches: the stage counts as not done.

        Raises
        ------
        UsageError
            When something other than a regular file is in the place of one; nothing was changed.
        """
        books = {CONFIG: config_yaml.encode(), SUMMARY: json_bytes(summary), STATE: state_bytes(state)}
        refuse_links(self.path, (*books, *files))
        recorded = {name for record in self.state.stages.values() for name in record.files}
        replaced = [*superseded, *(name for name in files if name not in recorded and (self.path / name).exists())]
        unchanged = {name for name in replaced if name in files and self._holds(name, files[name])}
        new = {name: content for name, content in files.items() if name not in unchanged}
        with staged(self.path, {**new, **books}) as place, interrupts_noted():
            self._move_away([name for name in dict.fromkeys(replaced) if name not in unchanged], books[CONFIG])
            place()
        self.state = state

    def _holds(self, name: str, content: bytes) -> bool:
        return sha256(self.path / name, len(content)) == hashlib.sha256(content).hexdigest()

    def _move_away(self, names: list[str], config_yaml: bytes) -> None:
        """Move files to this run's folder of superseded ones, with copies of the configuration, summary and state.

        A configuration that was edited is copied in any case.
        """
        edited = (self.path / CONFIG).exists() and not self._holds(CONFIG, config_yaml)
        if not names and not edited:
            return
        if self._attic is None:
            self._attic = next_numbered(self.path / SUPERSEDED)
            for name in BOOKS:
                with contextlib.suppress(FileNotFoundError):
                    shutil.copy2(self.path / name, self._attic / name)
        for name in names:
            target = self._attic / name
            target.parent.mkdir(parents=True, exist_ok=True)
            (self.path / name).replace(target)
            _remove_if_empty((self.path / name).parent)
        self._moved += names


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
        When another run is writing there, files with the names of results exist in what is not a run folder, or links
        or devices are where files of a run belong; nothing was changed.
    """
    reserved = tuple(reserved)
    require_usable(path, reserved)
    path.mkdir(parents=True, exist_ok=True)
    with locked(path, new=not os.path.lexists(path / STATE)):
        state = _state_to_change(path)
        if state is None:
            write_whole(path / STATE, state_bytes(State()))
        remove_partial(path, (*BOOKS, *reserved))
        yield RunFolder(path, state or State(), damaged=state is _UNKNOWN)


def require_usable(path: Path, reserved: Iterable[str]) -> None:
    """Require that a run may write to a folder: that it is one, free or a run's, and without links where files belong.

    Raises
    ------
    UsageError
        When it may not.
    """
    reserved = tuple(reserved)
    refuse_no_folder(path)
    refuse_links(path, (*BOOKS, LOCK, f"{SUPERSEDED}/*", *reserved))
    if _state_to_change(path) is None:
        refuse_foreign(path, reserved)


def _state_to_change(path: Path) -> State | None:
    """Read the state of a folder that a run may write to: an unknown one if it is damaged, None if there is none."""
    try:
        return read_state(path)
    except UsageError as error:
        refuse_foreign_state(path, error)
        return _UNKNOWN


def read_run_folder(path: Path) -> tuple[Config, State]:
    """Read the configuration and state of a run folder.

    Raises
    ------
    UsageError
        When it is not a run folder, its state is damaged, or its configuration was changed.
    """
    state = read_state(path) if path.is_dir() else None
    if state is None or not state.config_sha256:
        what = "is not a run folder" if path.exists() else "does not exist"
        raise UsageError(
            f"{path} {what}.\n  What to change: give the folder a run has written to, such as results/agder."
        )
    with contextlib.suppress(FileNotFoundError):
        open_regular_file(path / CONFIG, _MOST_CONFIG_BYTES).close()
    config = load_config(path / CONFIG)
    if state.config_sha256 not in (config_sha256(config), *_as_written_sha256(path / CONFIG)):
        raise UsageError(
            f"{path / CONFIG} was changed after the run: the results do not belong to it.\n"
            f"  What to change: run it, with gantry-tau run {path / CONFIG} --out {path}."
        )
    return config, state


def _as_written_sha256(file: Path) -> tuple[str, str]:
    """Hash a configuration as it is written, without the defaults of keys that are newer than its run.

    Runs of the first versions counted all sections, later ones leave some out.
    """
    written = read_yaml(file)
    assert isinstance(written, dict), "a configuration was read from the file"
    counted = {key: value for key, value in written.items() if key not in NOT_COUNTED}
    return config_sha256(written), config_sha256(counted)


def next_numbered(attic: Path) -> Path:
    """Create the next folder for superseded results."""
    taken = [int(entry.name) for entry in attic.glob("*") if _NUMBER.fullmatch(entry.name)]
    folder = attic / f"{max(taken, default=0) + 1:04d}"
    folder.mkdir(parents=True)
    return folder


def _remove_if_empty(folder: Path) -> None:
    if not any(folder.iterdir()):
        folder.rmdir()
