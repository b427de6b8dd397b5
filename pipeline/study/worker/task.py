"""One run of a study, from a request to a row; the row is on disk when the function returns."""

import contextlib
import json
import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.artifacts import json_bytes, write_whole
from pipeline.artifacts.layout import SUMMARY
from pipeline.artifacts.lock import locked
from pipeline.config import Config
from pipeline.errors import LockedError, NoSolutionError, PipelineError
from pipeline.regular_file import read_regular_file
from pipeline.run import RunOptions, run_pipeline
from pipeline.stage import Stage
from pipeline.study.cases import parse_case
from pipeline.study.config import Last, TwinConfig
from pipeline.study.keys import scalars
from pipeline.study.rows import Ending, Row, why

ROW = "row-"
"""What names of rows in a run folder begin with."""
_KEY_DIGITS = 16
_MOST_BYTES = 2**24
_LOCKED_S = 0.5
"""How often a run folder is tried that another worker is writing to."""
_NO_FIGURES = ("name", "config_sha256", "versions.")

Request = dict[str, Any]
"""What a worker is asked: `key`, `data`, `to`, `folder`, `time_limit_s`, `why_not`, `again`, `program`, ...."""


def row_file(request: Mapping[str, Any]) -> Path:
    """Name the file of the row, in the run folder."""
    return Path(request["folder"]) / f"{ROW}{request['key'][:_KEY_DIGITS]}.json"


def known_row(request: Mapping[str, Any]) -> Row | None:
    """Read the row that an earlier attempt has left; None if it left none, or has to be made again."""
    if request["again"]:
        return None
    try:
        row = Row.read(json.loads(read_regular_file(row_file(request), _MOST_BYTES)))
    except (OSError, ValueError, TypeError):
        return None
    return row if row.key == request["key"] and row.is_final(request["time_limit_s"]) else None


def keep_row(request: Mapping[str, Any], row: Row) -> Row:
    """Write a row into its run folder, whole or not at all."""
    write_whole(row_file(request), json_bytes(row.data()))
    return row


def run_case(request: Request) -> Row:
    """Run a case, unless it is already done; whatever goes wrong with it is in the row."""
    while True:
        if known := known_row(request):
            return known
        began = time.perf_counter()
        try:
            return keep_row(request, _attempt(request, began))
        except LockedError:
            # A worker that was given up may still be at it, or one that plans the same motion for another twin.
            time.sleep(_LOCKED_S)


def failed_row(request: Mapping[str, Any], ending: Ending, message: str, seconds: float) -> Row:
    """Make the row of a run that was ended from outside."""
    return Row(
        key=request["key"],
        ending=str(ending),
        reason=str(ending),
        message=message,
        seconds=seconds,
        time_limit_s=request["time_limit_s"],
        program=request["program"],
    )


def _attempt(request: Request, began: float) -> Row:
    ending, reason, message, figures = Ending.DONE, "", "", dict[str, Any]()
    try:
        _forget_twin(_twin_file(request))
        config, _, twin = parse_case(request["data"])
        _plan(request, config, twin)
    except LockedError:
        raise
    except PipelineError as error:
        ending, reason = why(error)
        message = error.reason if isinstance(error, NoSolutionError) else str(error)
    except MemoryError:
        ending, reason, message = Ending.ERROR, "out of memory", "there was not enough memory"
    except Exception as error:  # noqa: BLE001  # a fault of the program is a row, too, and ends no study
        ending, reason, message = Ending.ERROR, type(error).__name__, traceback.format_exc()
    if ending is not Ending.REFUSED:
        figures = _figures(Path(request["folder"]) / SUMMARY, _twin_file(request))
    seconds = time.perf_counter() - began
    return Row(
        request["key"], str(ending), reason, message, figures, seconds, request["time_limit_s"], request["program"]
    )


def _plan(request: Request, config: Config, twin: TwinConfig) -> None:
    last = Stage.RETIME if request["to"] == Last.SIMULATE else Stage(request["to"])
    folder = Path(request["folder"])
    report = run_pipeline(config, folder, RunOptions(last=last, why_not=request["why_not"]))
    report.require_complete()
    if request["to"] == Last.SIMULATE:
        from pipeline.study.worker.twin import simulate_run

        simulate_run(folder, twin, _twin_file(request))


def _twin_file(request: Mapping[str, Any]) -> Path:
    return row_file(request).with_name(row_file(request).name.replace("row", "twin"))


def _forget_twin(file: Path) -> None:
    """Remove what an earlier attempt has left of the twin, unless another worker is at it."""
    if file.exists():
        with locked(file.parent, new=False):
            file.unlink(missing_ok=True)


def _figures(*files: Path) -> dict[str, Any]:
    """Read the figures of a run: what there is of them, for a run that failed."""
    found: dict[str, Any] = {}
    for file in files:
        with contextlib.suppress(OSError, ValueError):
            found |= scalars(json.loads(read_regular_file(file, _MOST_BYTES)))
    return {path: value for path, value in found.items() if not path.startswith(_NO_FIGURES)}
