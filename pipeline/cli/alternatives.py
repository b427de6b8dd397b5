"""The best routes side by side: a run folder for each, and a table to choose from."""

import itertools
import shlex
from pathlib import Path

from rich.table import Table

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.reporter import make_reporter
from pipeline.config import Config
from pipeline.errors import NoSolutionError, UsageError
from pipeline.stage import Stage


def plan_alternatives(config: Config, folder: Path, count: int, force: bool, verbose: bool, why_not: bool) -> None:
    """Run stage one for each of the `count` best routes: `folder`, then `folder`-2, `folder`-3 and so on.

    Raises
    ------
    NoSolutionError
        When there are fewer; those that exist were shown and kept.
    UsageError
        When one of the folders beside `folder` holds another run; nothing was touched.
    """
    from pipeline.artifacts.results import load_route
    from pipeline.run import run_pipeline

    runs = [_of_rank(config, folder, rank) for rank in range(1, count + 1)]
    _require_room(runs[1:])
    where, table = folder, Table("route", "sum of kappa", "largest kappa", "steps", "working modes", "folder", box=None)
    missing: NoSolutionError | None = None
    for rank, (chosen, beside) in enumerate(runs, start=1):
        try:
            with make_reporter(messages_console(), verbose) as reporter:
                run_pipeline(chosen, beside, None, Stage.ROUTE, force, reporter, verbose, why_not and rank == 1)
        except NoSolutionError as error:
            missing = error
            break
        where = beside
        route = load_route(where)
        modes = " ".join(name for name, _ in itertools.groupby(route.mode_names))
        table.add_row(str(rank), f"{route.objective:.3f}", f"{route.kappa_max:.2f}", str(len(route)), modes, str(where))
    console = results_console()
    if table.row_count:
        console.print(table)
        path, out = shlex.quote(str(where / "config.yaml")), shlex.quote(str(where))
        console.print(f"Next: gantry-tau run {path} --out {out}, or of another folder", soft_wrap=True)
    if missing is not None:
        raise missing


def _of_rank(config: Config, folder: Path, rank: int) -> tuple[Config, Path]:
    """Give the configuration and the run folder of a route."""
    if rank == 1:
        return config.model_copy(update={"route": config.route.model_copy(update={"alternative": 1})}), folder
    route = config.route.model_copy(update={"alternative": rank})
    # Folders such as . and .. have no name of their own to put a number behind.
    named = folder if folder.name.strip(".") else folder.resolve()
    beside = named.parent / f"{named.name}-{rank}"
    return config.model_copy(update={"route": route, "name": f"{config.name}-{rank}"}), beside


def _require_room(runs: list[tuple[Config, Path]]) -> None:
    """Make sure that folders nobody has named hold no run but an alternative of the same rank."""
    from pipeline.artifacts.layout import CONFIG
    from pipeline.config.file import load_config

    for config, folder in runs:
        there = folder / CONFIG
        if there.exists() and load_config(there).route.alternative != config.route.alternative:
            raise UsageError(
                f"{folder} already holds another run, no alternative number {config.route.alternative}: nothing was "
                "touched.\n  What to change: give another folder with --out, or move that one away."
            )
