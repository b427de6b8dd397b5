"""Tables of simulated motions, and the files beside them that say so: none must pass for a measurement."""

import json
import os
from pathlib import Path
from typing import Any

from pipeline.cli.output import check_output
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file

_FACTS = ".json"
_MOST_FACTS_BYTES = 2**20


def check_simulated(output: Path, run: Path) -> Path | None:
    """Check where the table goes; give the name of the file beside it that says how it was made, if there is one."""
    from pipeline.artifacts.output import is_written_through

    check_output(output, run)
    if is_written_through(output):
        return None
    if output.suffix == _FACTS:
        raise UsageError(
            f"--output {output}: a {_FACTS} file beside the table says how it was made: give another ending"
        )
    facts = output.with_suffix(_FACTS)
    if os.path.lexists(facts) and not _is_simulated(facts):
        raise UsageError(
            f"--output {output}: {facts} would say how the table was made, but is there already, and says something "
            "else: give another name"
        )
    return facts


def _is_simulated(facts: Path) -> bool:
    """Check whether a file says of a table that it is simulated."""
    try:
        value = {} if facts.is_symlink() else json.loads(read_regular_file(facts, _MOST_FACTS_BYTES))
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(value, dict) and value.get("simulated") is True and "setting" in value


def write_simulated(output: Path, beside: Path | None, text: str, facts: dict[str, Any]) -> None:
    """Write a simulated table, and beside it, if there is such a file, how it was made."""
    from pipeline.artifacts import json_bytes, write_whole
    from pipeline.artifacts.output import write_output

    write_output(output, text.encode())
    if beside is not None:
        write_whole(beside, json_bytes({"simulated": True, **facts}))


def written_beside(beside: Path | None) -> str:
    """Say what was written beside a simulated table."""
    return "" if beside is None else f"; {beside}: how it was made"
