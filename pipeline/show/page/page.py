"""The whole page: opened, worked, and closed."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pipeline.show.page.app import App
from pipeline.show.page.panels.jog import JogPanel
from pipeline.show.page.panels.machine import MachinePanel
from pipeline.show.page.panels.plan import PlanPanel
from pipeline.show.page.panels.play import PlayPanel
from pipeline.show.page.panels.task import TaskPanel
from pipeline.show.page.server import HOST, close_server, open_server
from pipeline.show.playback import simulated_track
from pipeline.show.session import LoadedRun, Session


@contextmanager
def opened_page(
    session: Session, port: int, run: LoadedRun | None, simulated: Path | None
) -> Iterator[tuple[App, str]]:
    """Open the page, and give the application with its address; close it in the end.

    Parameters
    ----------
    port : int
        Where it is served, on the loopback address; 0 for any free one.
    run : LoadedRun, optional
        A run to be played.
    simulated : Path, optional
        A simulated motion of it, as `gantry-tau simulate --output` writes one.

    Raises
    ------
    UsageError
        When viser is not installed, the port cannot be used, or the simulated motion is none.
    """
    track = None if simulated is None else simulated_track(session.machine, simulated)
    server = open_server(port, f"gantry-tau show: {session.config.name}")
    planning: PlanPanel | None = None
    try:
        app = App(server, session)
        tabs = server.gui.add_tab_group()
        with tabs.add_tab("Jog"):
            JogPanel(app)
        with tabs.add_tab("Task"):
            TaskPanel(app)
        with tabs.add_tab("Machine"):
            MachinePanel(app)
        plan = tabs.add_tab("Plan")
        with tabs.add_tab("Play"):
            play = PlayPanel(app)
        with plan:
            planning = PlanPanel(app, play, None if run is None else run.folder)
        app.begin()
        if run is not None:
            play.load(run)
        if track is not None:
            play.add(track)
        yield app, f"http://{HOST}:{server.get_port()}"
    finally:
        if planning is not None:
            planning.close()
        close_server(server)
