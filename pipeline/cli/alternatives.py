"""The best routes side by side: a run folder for each, and a table to choose from."""

import itertools
import os
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rich.table import Table

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.reporter import make_reporter
from pipeline.config import Config
from pipeline.config.section import MOST_NAME
from pipeline.errors import NoSolutionError, UsageError
from pipeline.regular_file import read_regular_file
from pipeline.stage import Stage
from pipeline.summary.objective_words import ROUTE_QUANTITIES

if TYPE_CHECKING:
    from pipeline.run import RunOptions
    from pipeline.run.stage_specs import Specs


def plan_alternatives(config: Config, folder: Path, count: int, options: "RunOptions", specs: "Specs") -> None:
    """Run stage one for each of the `count` best routes, into `folder`, `folder`-2, `folder`-3 and so on.

    Raises
    ------
    NoSolutionError
        When there are fewer, or some are not proven optimal; those that were found are shown and kept.
    UsageError
        When one of the folders beside `folder` holds another run; nothing was changed.
    """
    from pipeline.run import open_results, run_pipeline
    from pipeline.summary.route import unproven_route

    runs = [_of_rank(config, folder, rank) for rank in range(1, count + 1)]
    _refuse_other_runs(runs, specs)
    quantity = ROUTE_QUANTITIES[config.route.objective]
    last, table = (
        folder,
        Table("route", quantity.heading, "largest kappa", "steps", "working modes", "folder", box=None),
    )
    missing: NoSolutionError | None = None
    for rank, (chosen, target) in enumerate(runs, start=1):
        why_not = options.why_not and rank == 1
        try:
            with make_reporter(messages_console(), options.verbose) as reporter:
                report = run_pipeline(chosen, target, replace(options, why_not=why_not, unproven=True), reporter, specs)
        except NoSolutionError as error:
            missing = error
            break
        last, missing = target, unproven_route(report.outcomes[-1].section) or missing
        route = open_results(target, Stage.ROUTE).route
        modes = " ".join(name for name, _ in itertools.groupby(route.mode_names))
        table.add_row(str(rank), f"{route.objective:.3f}", f"{route.kappa_max:.2f}", str(len(route)), modes, str(last))
    console = results_console()
    if table.row_count:
        from pipeline.artifacts.layout import CONFIG

        console.print(table)
        path, out = shlex.quote(str(last / CONFIG)), shlex.quote(str(last))
        console.print(f"Next: gantry-tau run {path} --out {out}, or with another folder", soft_wrap=True)
    if missing is not None:
        raise missing


def _of_rank(config: Config, folder: Path, rank: int) -> tuple[Config, Path]:
    """Give the configuration and the run folder of a route."""
    route = config.route.model_copy(update={"alternative": rank})
    if rank == 1:
        return config.model_copy(update={"route": route}), folder
    # Folders such as . and .. have no name of their own to which a number can be added.
    named = folder if folder.name.strip(".") else Path(os.path.realpath(folder))
    beside = named.parent / f"{named.name}-{rank}"
    return config.model_copy(update={"route": route, "name": f"{config.name[: MOST_NAME - 3]}-{rank}"}), beside


def _refuse_other_runs(runs: list[tuple[Config, Path]], specs: "Specs") -> None:
    """Refuse folders that no run may write to, and beside the named one those of anything but an equal alternative."""
    from pipeline.artifacts.folder import require_usable
    from pipeline.artifacts.layout import CONFIG
    from pipeline.config.file import load_config

    for config, folder in runs:
        require_usable(folder, [pattern for spec in specs for pattern in spec.patterns])
        there, rank = folder / CONFIG, config.route.alternative
        if rank > 1 and there.exists() and load_config(there, read_regular_file).route.alternative != rank:
            raise UsageError(
                f"{folder} already holds another run, not alternative number {rank}: nothing was changed.\n"
                "  What to change: give another folder with --out, or move that one away."
            )
