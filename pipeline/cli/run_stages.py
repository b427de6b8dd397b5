"""Running stages for a command, with progress, and showing what was done."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.reporter import make_reporter
from pipeline.cli.stage_table import stage_table

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.run import RunOptions
    from pipeline.run.stage_specs import Specs


def run_stages(path: Path, config: "Config", out: Path | None, options: "RunOptions", specs: "Specs") -> None:
    """Run the stages of a configuration read from a file, and show what was done and what to do next.

    Raises
    ------
    PipelineError
        When the run ends without a result, or a part of one is missing.
    """
    from pipeline.artifacts.layout import REPORT
    from pipeline.config.file import results_folder
    from pipeline.run import run_pipeline
    from pipeline.run.run_report import files_to_open
    from pipeline.run.stage_specs import spec_of

    folder = out or results_folder(config.name)
    with make_reporter(messages_console(), options.verbose) as reporter:
        report = run_pipeline(config, folder, options, reporter, specs)
    console = results_console()
    console.print(stage_table(report, specs))
    found = files_to_open(folder, [outcome.stage for outcome in report.outcomes], specs)
    width = max(len(str(file)) for file, _ in found)
    for file, what in found:
        console.print(f"{file!s:<{width}}  {what}", soft_wrap=True)
    if report.superseded is not None:
        attic, names = report.superseded
        tops = ", ".join(dict.fromkeys(name.split("/")[0] for name in names))
        console.print(f"Out of date, and moved to {attic}: {tops}", soft_wrap=True)
    report.require_complete()
    next_step = spec_of(specs, options.last).next_step.format(
        config=shlex.quote(str(path)),
        out=f" --out {shlex.quote(str(folder))}" if out else "",
        folder=shlex.quote(str(folder)),
        report=shlex.quote(str(folder / REPORT)),
    )
    console.print(f"Next: {next_step}", soft_wrap=True)
