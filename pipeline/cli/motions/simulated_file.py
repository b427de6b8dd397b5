"""Tables of simulated motions, and the files beside them that say so: none must pass for a measurement."""

from pathlib import Path
from typing import Any

from pipeline.cli.output import check_facts


def check_simulated(output: Path, run: Path) -> Path | None:
    """Check where the table goes; give the name of the file beside it that says how it was made, if there is one."""
    return check_facts(output, lambda facts: facts.get("simulated") is True and "setting" in facts, run)


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
