"""The state of a run folder: for each stage, what its result was made from and the hashes of its files."""

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from pipeline.artifacts.files import sha256
from pipeline.artifacts.layout import STATE
from pipeline.stage import Stage


class Record(BaseModel):
    """How a stage ended.

    Attributes
    ----------
    fingerprint : str
        Hash of everything the result was made from.
    status : str
        Whether there is a result.
    seconds : float
        How long it took.
    files : dict
        Hash of every file written, by name.
    summary : dict
        The stage's part of `summary.json`.
    """

    model_config = ConfigDict(frozen=True)

    fingerprint: str
    status: Literal["done", "failed"]
    seconds: float
    files: dict[str, str]
    summary: dict[str, Any]

    def damage(self, folder: Path) -> list[str]:
        """List the files that are missing or no longer what was written."""
        return [name for name, expected in self.files.items() if sha256(folder / name) != expected]


class State(BaseModel):
    """The records of a run folder, and the configuration they belong to."""

    model_config = ConfigDict(frozen=True)

    config_sha256: str = ""
    stages: dict[Stage, Record] = {}


def read_state(folder: Path) -> State | None:
    """Read the state; an unreadable one counts as empty, None means that there is none."""
    try:
        return State.model_validate_json((folder / STATE).read_bytes())
    except FileNotFoundError:
        return None
    except ValidationError:
        return State()
