"""The best routes side by side: a run folder for each, and a table to choose from."""

import itertools
from pathlib import Path

from rich.table import Table

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.reporter import make_reporter
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.stage import Stage


def plan_alternatives(config: Config, folder: Path, count: int, force: bool, verbose: bool, why_not: bool) -> None:
    """Run stage one for each of the `count` best routes: `folder`, then `folder`-2, `folder`-3 and so on.

    Raises
    ------
    NoSolutionError
        When there are fewer; those that exist were shown and kept.
    """
    from pipeline.artifacts.results import load_route
    from pipeline.run import run_pipeline

    where, table = folder, Table("route", "sum of kappa", "largest kappa", "steps", "working modes", "folder", box=None)
    missing: NoSolutionError | None = None
    for rank in range(1, count + 1):
        chosen, beside = _of_rank(config, folder, rank)
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
        console.print(
            f"Next: gantry-tau run {where / 'config.yaml'} --out {where}, or of another folder", soft_wrap=True
        )
    if missing is not None:
        raise missing


def _of_rank(config: Config, folder: Path, rank: int) -> tuple[Config, Path]:
    """Give the configuration and the run folder of a route."""
    if rank == 1:
        return config.model_copy(update={"route": config.route.model_copy(update={"alternative": 1})}), folder
    route = config.route.model_copy(update={"alternative": rank})
    where = folder.with_name(f"{folder.name}-{rank}")
    return config.model_copy(update={"route": route, "name": where.name}), where
