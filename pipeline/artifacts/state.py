"""The state of a run folder: for each stage, what its result was made from and the hashes of its files."""

import errno
import json
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from pipeline.artifacts.files import json_bytes, sha256
from pipeline.artifacts.layout import STATE, SUMMARY
from pipeline.config.file import config_sha256
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file
from pipeline.stage import Stage
from pipeline.summary.versions import PACKAGE

_MOST_BYTES = 2**24
"""Size of the largest state that is read: it has the summary of a run, and the names of its files."""


def _inside(name: str) -> str:
    """Require the name of a file within the run folder."""
    path = PurePosixPath(name)
    if path.is_absolute() or not path.parts or ".." in path.parts or "\0" in name:
        raise ValueError("not the name of a file in the run folder")
    return name


class Record(BaseModel):
    """How a stage ended.

    Attributes
    ----------
    fingerprint : str
        Hash of everything the result was made from; empty if that is not known for certain.
    status : str
        Whether there is a result.
    seconds : float
        How long it took.
    files : dict
        Hash of every file written, by name.
    sizes : dict
        The bytes of every file written, by name; earlier versions did not record them.
    summary : dict
        The stage's part of `summary.json`.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")

    fingerprint: str
    status: Literal["done", "failed"]
    seconds: float = Field(ge=0.0, allow_inf_nan=False)
    files: dict[Annotated[str, AfterValidator(_inside)], str]
    sizes: dict[str, int] = {}
    summary: dict[str, Any]

    def damage(self, folder: Path) -> list[str]:
        """List the files that are missing or no longer what was written."""
        return [name for name, expected in self.files.items() if self._hash(folder, name) != expected]

    def _hash(self, folder: Path, name: str) -> str | None:
        return sha256(folder / name, self.sizes[name]) if name in self.sizes else sha256(folder / name)


class State(BaseModel):
    """The records of a run folder, and the configuration they belong to."""

    model_config = ConfigDict(frozen=True)

    config_sha256: str = ""
    stages: dict[Stage, Record] = {}


class _StateFile(BaseModel):
    """A state as a file; the seal is a hash of the rest, so that nothing in it can be other than it was written."""

    model_config = ConfigDict(strict=True, extra="forbid")

    config_sha256: str
    stages: dict[Stage, Record]
    seal: str | None = None


def state_bytes(state: State) -> bytes:
    """Write the state for its file."""
    return json_bytes({**state.model_dump(mode="json"), "seal": _seal(state)})


def read_state(folder: Path) -> State | None:
    """Read the state of a run folder; None means that there is none.

    Records of versions that sealed nothing have no fingerprint: their results can be read, but not taken up again.

    Raises
    ------
    UsageError
        When the file is damaged, was changed, or is another program's.
    """
    file = folder / STATE
    try:
        read = _StateFile.model_validate_json(read_regular_file(file, _MOST_BYTES))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except ValidationError as error:
        raise _unusable(folder, _first_fault(error)) from None
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EISDIR, errno.EFBIG):
            raise
        raise _unusable(folder, f"it {error.strerror}") from None
    state = State(config_sha256=read.config_sha256, stages=read.stages)
    if read.seal is None:
        unsealed = {stage: record.model_copy(update={"fingerprint": ""}) for stage, record in read.stages.items()}
        return state.model_copy(update={"stages": unsealed})
    if read.seal != _seal(state):
        raise _unusable(folder, "it was changed after it had been written")
    return state


def is_of_a_run(folder: Path) -> bool:
    """Check by the summary whether a run has written to a folder, for where the state cannot be read."""
    try:
        summary = json.loads(read_regular_file(folder / SUMMARY, _MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return False
    versions = summary.get("versions") if isinstance(summary, dict) else None
    return isinstance(versions, dict) and PACKAGE in versions and "config_sha256" in summary


def _seal(state: State) -> str | None:
    """Hash a state; None if it holds what no run can have written."""
    try:
        return config_sha256(state)
    except (ValueError, RecursionError):
        return None


def _first_fault(error: ValidationError) -> str:
    fault = error.errors(include_url=False, include_input=False)[0]
    place = ".".join(str(part) for part in fault["loc"])
    return f"{place}: {fault['msg']}" if place else fault["msg"]


def _unusable(folder: Path, why: str) -> UsageError:
    return UsageError(
        f"{folder / STATE} is damaged, or was not written by this program: {why}.\n"
        "  What to change: run the pipeline again into that folder, if it is the folder of a run; or give another one."
    )
