"""The command that checks a configuration."""

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import results_console
from pipeline.cli.options import load_grid, load_task, naming
from pipeline.cli.output import check_picture, save_picture
from pipeline.errors import ConfigError, UnfitConfigError, UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from pipeline.config import Config
    from pipeline.machine.geometry import Machine
    from pipeline.route.regions.endpoints import Endpoint


def check(
    config: Annotated[Path | None, typer.Argument(metavar="CONFIG", help="The YAML file to check.")] = None,
    schema: Annotated[
        bool, typer.Option("--schema", help="Print the JSON schema of configurations instead, for your editor.")
    ] = False,
    commented: Annotated[
        bool, typer.Option("--yaml", help="Print it as YAML instead: every key with its default and its meaning.")
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="FILE", readable=False, help="Draw the machine at start and goal: .png, .pdf or .svg."
        ),
    ] = None,
) -> None:
    """Check a configuration, and show the machine: degrees of freedom, reach, grid, start and goal.

    Exits with 2 if a key is wrong, the grid takes more memory than allowed,
    the machine cannot be at the start or goal within its limits, or counting
    shows that the task is impossible: too few positions, mode changes, travel
    or tilt, or a box to avoid without a way round it. The tables are shown
    all the same, with start and goal if the machine can reach both.
    """
    if schema:
        from pipeline.config.file import schema_text

        typer.echo(schema_text())
        return
    if config is None:
        raise UsageError("check needs a CONFIG, or --schema")
    if commented:
        from pipeline.config.commented import commented_yaml

        typer.echo(commented_yaml(load_task(config)), nl=False)
        return

    from pipeline.cli.machine_report import machine_report
    from pipeline.machine.geometry import build_machine
    from pipeline.route.checked_task import require_sound_task

    check_picture(picture)
    loaded = load_grid(config)
    machine = build_machine(loaded.machine)
    console = results_console()
    try:
        with naming(config):
            ends = require_sound_task(loaded, machine)
    except (ConfigError, UnfitConfigError):
        _show_refused(loaded, machine, picture, console)
        raise
    for part in machine_report(loaded, machine, ends):
        console.print(part)
    if picture is not None:
        _draw(loaded, machine, ends, picture)
        console.print(f"{picture}: the machine at start and goal, and its platform", soft_wrap=True)
    console.print(f"{config} is valid. Next: gantry-tau run {shlex.quote(str(config))}", soft_wrap=True)


def _show_refused(config: "Config", machine: "Machine", picture: Path | None, console: "Console") -> None:
    """Show the machine, and where it is refused as far as it can be there, before the refusal itself."""
    from pipeline.cli.machine_report import refused_report
    from pipeline.route.regions.endpoints import reached_ends

    ends = reached_ends(config, machine)
    for part in refused_report(config, machine, ends):
        console.print(part)
    if picture is not None and len(ends) == 2:
        _draw(config, machine, (ends["start"], ends["goal"]), picture)
        console.print(f"{picture}: the machine at start and goal, which are refused", soft_wrap=True)


def _draw(config: "Config", machine: "Machine", ends: "tuple[Endpoint, Endpoint]", picture: Path) -> None:
    import numpy as np

    from pipeline.figures.task import task_figure
    from pipeline.machine.geometry import MODES

    pose, q_m = np.stack([end.pose for end in ends]), np.stack([end.q_m for end in ends])
    titles = [f"{name}, {MODES[end.mode]}" for name, end in zip(("start", "goal"), ends, strict=True)]
    save_picture(task_figure(config, machine, pose, q_m, titles), picture)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        check,
        (
            "gantry-tau check configs/agder.yaml",
            "gantry-tau check configs/agder.yaml --yaml > my.yaml    (every key, to be changed)",
            "gantry-tau check configs/agder-bodies.yaml --picture machine.png",
            "gantry-tau check --schema > gantry-tau.schema.json",
            "and as the first line of a YAML file, so that editors complete it:",
            "# yaml-language-server: $schema=gantry-tau.schema.json",
        ),
    ),
)
"""Every command with its examples."""
