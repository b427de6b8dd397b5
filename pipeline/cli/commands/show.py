"""The command that opens the page on which the machine is jogged, planned for and played."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeline.cli.console import results_console
from pipeline.errors import UsageError

if TYPE_CHECKING:
    from pipeline.show.session import LoadedRun, Session

_BASE = "agder"


def show(
    source: Annotated[
        Path | None,
        typer.Argument(
            metavar="[CONFIG | RUN]", help="A YAML file, or the folder of a run. Default: the reference machine."
        ),
    ] = None,
    port: Annotated[
        int, typer.Option("--port", metavar="N", min=0, max=65_535, help="Port of the page; 0: any free one.")
    ] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address of the page.")] = False,
    simulated: Annotated[
        Path | None,
        typer.Option(
            "--simulated", metavar="FILE", help="A motion to play beside those of RUN, from `simulate --output FILE`."
        ),
    ] = None,
) -> None:
    """Open a page on which the machine is jogged, a task is set and planned, and a run is played.

    Sliders or the tool itself move the machine; shown are every limit with its
    margin, the nearest one by name, and the map of kappa for the tilt and
    working mode. Start, goal, visits and boxes to avoid are taken from the
    present pose, saved as YAML, and planned from there. Ctrl-C ends it.

    The page is served on this machine only (127.0.0.1), and only to pages
    that come from there. It needs viser, which comes with the extra `show`.
    """
    session, run = _open(source)
    if simulated is not None and run is None:
        raise UsageError("--simulated goes with the folder of a RUN: a simulated motion is one of its machine")
    from pipeline.show.page.page import opened_page

    try:
        with opened_page(session, port, run, simulated) as (app, address):
            results_console().print(f"{address}\nCtrl-C ends it.", soft_wrap=True)
            if not no_browser:
                import webbrowser

                webbrowser.open(address)
            app.run()
    except KeyboardInterrupt:
        results_console().print("ended")


def _open(source: Path | None) -> "tuple[Session, LoadedRun | None]":
    from pipeline.show.session import Session, is_run_folder, load_run

    if source is None:
        from pipeline.config.packaged import packaged_config

        return Session(packaged_config(_BASE, "my-machine"), Path("my-machine.yaml")), None
    if is_run_folder(source):
        from pipeline.artifacts.layout import CONFIG

        run = load_run(source)
        session = Session(run.results.config, source / CONFIG)
        return session, run
    from pipeline.config.file import load_config

    return Session(load_config(source), source), None


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = (
    (
        show,
        (
            "gantry-tau show    (the reference machine, to start from)",
            "gantry-tau show configs/quick.yaml",
            "gantry-tau show results/agder --no-browser --port 8080",
            "gantry-tau simulate results/agder --output twin.csv; gantry-tau show results/agder --simulated twin.csv",
        ),
    ),
)
"""Every command with its examples."""
