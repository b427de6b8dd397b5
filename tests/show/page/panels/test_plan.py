"""What was planned is played if it is of the machine as it is."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.show.page.panels import plan
from pipeline.show.page.panels.plan import PlanPanel
from pipeline.stage import Stage
from tests.show.page.panels.conftest import Opened


class EndedAtOnce:
    """A process that has planned, and tells it when it is asked."""

    listen: Callable[[dict[str, Any]], None]

    def __init__(self, file: Path, folder: Path, last: Stage, listen: Callable[[dict[str, Any]], None]) -> None:
        EndedAtOnce.listen = listen

    def close(self) -> None:
        """Nothing is left of it."""


@pytest.mark.parametrize(("changes", "played"), [((), 2), ((2.6,), 0), ((2.6, None), 2)])
def test_a_plan_of_another_machine_is_not_played(
    changes: tuple[float | None, ...], played: int, opened: Opened, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A machine that is changed while a plan is made has no motion; changed back, it has."""
    monkeypatch.setattr(plan, "Planning", EndedAtOnce)
    panel = PlanPanel(opened.app, opened.play, folder)
    panel.plan()
    for travel_m in changes:
        opened.lengthen_rail(opened.run.results.config.machine.rails[0].travel_m[1] if travel_m is None else travel_m)
    EndedAtOnce.listen({"failure": ""})
    job = opened.app.jobs.take(0.0)
    assert job is not None
    job()
    assert len(opened.play.tracks) == played
    assert all(
        track.samples.machine.travel_m[0, 1] == opened.app.session.machine.travel_m[0, 1]
        for track in opened.play.tracks
    )
