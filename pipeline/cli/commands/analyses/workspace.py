"""The command that measures the usable workspace of a machine."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from pipeline.cli.console import messages_console, results_console
from pipeline.cli.output import check_picture, refuse_same, save_picture, text_table


def workspace(
    config: Annotated[Path, typer.Argument(metavar="CONFIG", help="The YAML file with the machine.")],
    kappa_max: Annotated[float, typer.Option("--kappa-max", metavar="K", min=1.0, help="Upper limit of kappa.")] = 40.0,
    rx_deg: Annotated[
        float, typer.Option("--rx", metavar="DEG", min=-85.0, max=85.0, help="Tilt about x in degrees.")
    ] = 0.0,
    rz_deg: Annotated[
        float, typer.Option("--rz", metavar="DEG", min=-85.0, max=85.0, help="Tilt about z in degrees.")
    ] = 0.0,
    step_m: Annotated[
        float, typer.Option("--step", metavar="M", min=0.001, max=0.2, help="Grid step in y and z in metres.")
    ] = 0.005,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, unrounded.")] = False,
    picture: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE", readable=False, help="Draw maps: .png, .pdf or .svg.")
    ] = None,
    volume: Annotated[
        Path | None,
        typer.Option("--picture-3d", metavar="FILE", readable=False, help="Draw all left and all right in 3-D."),
    ] = None,
) -> None:
    """Measure the usable workspace of every working mode, and of all of them together.

    A position is usable if it can be reached at this tilt with kappa below
    its limit, within the strokes, rails and cones of joints, and with the
    clearance between links that CONFIG asks for. Volumes are also computed at
    twice the grid step, to show how far they have converged.
    """
    check_picture(picture)
    check_picture(volume, option="--picture-3d")
    refuse_same(picture, volume, "--picture and --picture-3d")
    from pipeline.artifacts import json_bytes
    from pipeline.config.file import load_config
    from pipeline.machine.geometry import build_machine
    from pipeline.workspace.table import (
        TABLE_HEADER,
        at_two_steps,
        setting_text,
        space_text,
        table_cells,
        workspace_data,
        workspace_rows,
    )
    from pipeline.workspace.usable import WorkspaceSetting

    loaded = load_config(config)
    machine = build_machine(loaded.machine)
    setting = WorkspaceSetting(kappa_max, math.radians(rx_deg), math.radians(rz_deg), step_m)
    with messages_console().status("measuring the workspace"):
        fine, coarse = at_two_steps(machine, setting)
    rows = workspace_rows(fine, coarse)
    if as_json:
        typer.echo(json_bytes(workspace_data(machine, setting, rows)), nl=False)
    else:
        console = results_console()
        console.print(text_table(f"{loaded.name}: usable workspace", TABLE_HEADER, table_cells(rows)))
        console.print(setting_text(machine, setting), soft_wrap=True)
        console.print(space_text(machine, setting, rows[-1]), soft_wrap=True)
    if picture is not None:
        from pipeline.figures.maps.workspace import workspace_figure

        save_picture(workspace_figure(fine), picture)
        messages_console().print(
            f"{picture}: usable length along x, per working mode and in all of them", soft_wrap=True
        )
    if volume is not None:
        from pipeline.figures.maps.volume import workspace_volume_figure

        save_picture(workspace_volume_figure(machine, fine), volume)
        messages_console().print(
            f"{volume}: the workspaces of all arms left and of all arms right, in 3-D", soft_wrap=True
        )


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        workspace,
        (
            "gantry-tau workspace configs/agder.yaml",
            "gantry-tau workspace configs/agder.yaml --rx -10 --kappa-max 30 --json",
            "gantry-tau workspace configs/agder.yaml --picture workspace.png --picture-3d volume.png",
        ),
    ),
)
"""Every command with its examples."""
