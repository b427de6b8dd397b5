"""A page on a run that took no time."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.show.edits import with_machine
from pipeline.show.page.app import App
from pipeline.show.page.panels.play import PlayPanel
from pipeline.show.page.server import close_server, open_server
from pipeline.show.session import LoadedRun, Session, load_run
from pipeline.stage import Stage
from tests.run.fake_stages import FakeStages


@dataclass(frozen=True)
class Opened:
    """The page, its panel of motions, and the run that was opened."""

    app: App
    play: PlayPanel
    run: LoadedRun

    def lengthen_rail(self, travel_m: float) -> None:
        """Change the machine."""
        self.app.edit(lambda config: with_machine(config, {"rails.0.travel_m": [0.0, travel_m]}))


@pytest.fixture(scope="session")
def folder(quick_config: Config, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a run with a route and a path."""
    path = tmp_path_factory.mktemp("panels") / "run"
    FakeStages().run(quick_config, path, last=Stage.REFINE)
    return path


@pytest.fixture
def opened(folder: Path) -> Iterator[Opened]:
    """Open a page on the run, as the command does."""
    pytest.importorskip("viser")
    run = load_run(folder)
    server = open_server(0, "test")
    app = App(server, Session(run.results.config, folder / "config.yaml"))
    play = PlayPanel(app)
    app.begin()
    play.load(run)
    yield Opened(app, play, run)
    close_server(server)
