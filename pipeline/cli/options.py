"""Arguments and options that several commands have, and what they stand for."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.errors import ConfigError

if TYPE_CHECKING:
    from pipeline.config import Config
    from pipeline.run.stage_specs import Specs

ConfigArgument = Annotated[Path, typer.Argument(metavar="CONFIG", help="The YAML file with machine, task and options.")]
RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="The folder a run has written to.")]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder for the results. Default: results/<name in CONFIG>."),
]
ForceOption = Annotated[bool, typer.Option("--force", help="Also run stages that are up to date.")]
NoWhyNotOption = Annotated[
    bool,
    typer.Option("--no-why-not", help="If no route exists, do not find out what prevents it (takes minutes)."),
]
SpeedOption = Annotated[
    float | None,
    typer.Option("--speed", metavar="PART", help="Part of the full speed, above 0, at most 1: for a slow first run."),
]
UnprovenOption = Annotated[
    bool,
    typer.Option(
        "--unproven", help="Go on with a route whose search ended at route.time_limit_s: valid, perhaps not the best."
    ),
]
VerboseOption = Annotated[bool, typer.Option("--verbose", "-v", help="Show the solvers' logs.")]


def load_task(path: Path) -> "Config":
    """Read a configuration; check that its grid fits, that the machine can be at its ends, and what counting excludes.

    Raises
    ------
    ConfigError
        When it cannot be used; names the file.
    """
    from pipeline.machine.geometry import build_machine
    from pipeline.route.regions.counting import require_possible_task

    config = load_grid(path)
    with naming(path):
        require_possible_task(config, build_machine(config.machine))
    return config


def load_grid(path: Path) -> "Config":
    """Read a configuration, and check that its grid fits, but not what it asks of the machine.

    Raises
    ------
    ConfigError
        When it cannot be used; names the file.
    """
    from pipeline.config.file import load_config
    from pipeline.route.regions.size import require_grid_fits

    config = load_config(path)
    with naming(path):
        require_grid_fits(config)
    return config


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Name the file of a configuration that is refused."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(list(error.issues), str(path)) from None


def specs_of(context: typer.Context) -> "Specs":
    """Give the stages that commands run: those the application was called with as its object, or the usual ones."""
    from pipeline.run.stage_specs import SPECS

    return context.obj or SPECS
