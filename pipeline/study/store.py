"""The rows of a study in one SQLite file: a run that is in it is done, whatever happens next."""

import json
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from pipeline.errors import UsageError
from pipeline.study.rows import Row

STORE = "study.sqlite"
_VERSION = 1
_SCHEMA = f"""
    CREATE TABLE IF NOT EXISTS rows (key TEXT PRIMARY KEY, row TEXT NOT NULL) WITHOUT ROWID;
    CREATE TABLE IF NOT EXISTS program (version TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS deaths (key TEXT NOT NULL, how TEXT NOT NULL);
    PRAGMA user_version = {_VERSION};
"""


class Store:
    """The rows of a study, and how often a run has ended the process that ran it.

    Only the client writes, while it holds the lock of the study: a file that is locked as a whole needs no shared
    memory, so that the write-ahead log also works where the folder is on a network. Every row is on disk before the
    call returns.

    Raises
    ------
    UsageError
        When the file is damaged, another program's, or of another version.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / STORE
        try:
            self._database = sqlite3.connect(self._file, isolation_level=None)
            self._database.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("PRAGMA synchronous = FULL")
            (version,) = self._database.execute("PRAGMA user_version").fetchone()
            if version not in (0, _VERSION):
                raise self._unusable(f"it has version {version}, not {_VERSION}")
            self._database.executescript(_SCHEMA)
        except sqlite3.DatabaseError as error:
            raise self._unusable(str(error)) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._database.close()

    def add(self, row: Row) -> None:
        """Add a row, or replace the one with its key."""
        self._database.execute("INSERT OR REPLACE INTO rows VALUES (?, ?)", (row.key, json.dumps(row.data())))

    def row(self, key: str) -> Row | None:
        """Give the row of a key; None if there is none."""
        found = self._database.execute("SELECT row FROM rows WHERE key = ?", (key,)).fetchone()
        return None if found is None else Row.read(json.loads(found[0]))

    def rows(self) -> Iterator[Row]:
        """Give all rows, by key."""
        for (text,) in self._database.execute("SELECT row FROM rows ORDER BY key"):
            yield Row.read(json.loads(text))

    def add_death(self, key: str, how: str) -> int:
        """Note that a run has ended its process; return how often it has."""
        self._database.execute("INSERT INTO deaths VALUES (?, ?)", (key, how))
        (count,) = self._database.execute("SELECT count(*) FROM deaths WHERE key = ?", (key,)).fetchone()
        return int(count)

    def forget_deaths(self, key: str) -> None:
        """Give a run all its attempts again."""
        self._database.execute("DELETE FROM deaths WHERE key = ?", (key,))

    def set_program(self, version: str) -> None:
        """Note which program leads the study: rows of others stay, and do not count."""
        self._database.execute("BEGIN")
        self._database.execute("DELETE FROM program")
        self._database.execute("INSERT INTO program VALUES (?)", (version,))
        self._database.execute("COMMIT")

    def program(self) -> str:
        """Give the program that led the study last; empty if none did."""
        found = self._database.execute("SELECT version FROM program").fetchone()
        return "" if found is None else str(found[0])

    def _unusable(self, why: str) -> UsageError:
        return UsageError(
            f"{self._file} cannot be used: {why}.\n"
            "  What to change: move it away, and give the same command; runs that are done are found by their folders."
        )
