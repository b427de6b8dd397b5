"""The command that writes the report of a run."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.options import RunArgument, specs_of
from pipeline.cli.output import check_output


def report(
    context: typer.Context,
    run: RunArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", metavar="FILE", readable=False, help="Where to write to. Default: report.html in RUN."
        ),
    ] = None,
) -> None:
    """Write the report of a run again: one page to open in a browser, offline and without a server.

    It shows what there is: a run that failed or is not complete has a report
    too, which says so. Every run writes its own report when it ends.
    """
    from pipeline.run.reporting import write_report

    check_output(output, run)
    with messages_console().status("writing the report"):
        target = write_report(run, output, specs_of(context))
    size = f": {target.stat().st_size / 1e3:,.0f} kB" if target.is_file() else ""
    results_console().print(f"{target}{size}", soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        report,
        (
            "gantry-tau report results/agder",
            "gantry-tau report results/agder --output agder.html",
        ),
    ),
)
"""Every command with its examples."""
