"""Poses to measure next, as a command was asked for them: shown, and as a table to be filled in."""

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.output import check_output, print_json, refuse_same, text_table
from pipeline.errors import UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from pipeline.arrays import FloatArray
    from pipeline.calibrate import NextPoses, Setting
    from pipeline.config import Config


def check_next(next_file: Path | None, following: int, others: list[Path]) -> None:
    """Check where the table goes, before anything is computed.

    Raises
    ------
    UsageError
        When no poses are asked for, or the file is one of the others.
    """
    if next_file is None:
        return
    if not following:
        raise UsageError("--next-output goes with --next N")
    check_output(next_file, option="--next-output")
    for other in others:
        refuse_same(next_file, other, "--next-output and another file")


def begin(
    config: "Config",
    reflectors_m: "FloatArray",
    setting: "Setting",
    wanted: tuple[Path | None, int, Path | None],
    as_json: bool,
) -> None:
    """Propose the first poses, where nothing was measured yet.

    Raises
    ------
    UsageError
        When none are asked for, or something that needs measured poses.
    """
    from pipeline.calibrate import first_poses
    from pipeline.calibrate.report import next_data

    output, count, next_file = wanted
    if not count or output is not None:
        raise UsageError("FILE is missing: give measured poses, or --next N (without --output) for poses to measure")
    proposed = first_poses(config, reflectors_m, setting, count)
    if as_json:
        print_json({"next": next_data(proposed)})
    propose(proposed, len(reflectors_m), next_file, None if as_json else results_console())


def propose(proposed: "NextPoses", reflector_count: int, next_file: Path | None, console: "Console | None") -> None:
    """Show proposed poses, unless JSON has them, and write their table."""
    from pipeline.artifacts.output import write_output
    from pipeline.calibrate.report import NEXT_HEADER, next_cells, next_columns
    from pipeline.export.csv import format_csv

    if console is not None:
        title = "poses to measure next, with the predicted error of a reflector anywhere"
        console.print(text_table(title, NEXT_HEADER, next_cells(proposed), (0, 1)))
    if next_file is not None:
        write_output(next_file, format_csv(next_columns(proposed, reflector_count)).encode())
        messages_console().print(
            f"{next_file}: {len(proposed.q_m)} poses to measure; to drive there: gantry-tau tour", soft_wrap=True
        )
