"""Planning in a process of its own: it tells what happens, says why it fails, and can be stopped."""

from pathlib import Path
from queue import SimpleQueue
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config
from pipeline.show.planning.process import Planning
from pipeline.show.planning.work import STOPPED, plan
from pipeline.stage import Stage

PATIENCE_S = 120.0


def events_of(file: Path, folder: Path, last: Stage) -> list[dict[str, Any]]:
    """Plan in this process, and give what is told."""
    told: list[dict[str, Any]] = []
    plan(file, folder, last, told.append)
    return told


def test_it_tells_and_stops(agder_config: Config, tmp_path: Path) -> None:
    """Stages are told as they begin; asked to stop, it says that it did, and ends."""
    file = tmp_path / "agder.yaml"
    file.write_text(dump_config(agder_config))
    heard: SimpleQueue[dict[str, Any]] = SimpleQueue()
    process = Planning(file, tmp_path / "run", Stage.ROUTE, heard.put)
    try:
        assert heard.get(timeout=PATIENCE_S) == {"stage": "regions", "message": "started"}
        process.stop()
        while "failure" not in (event := heard.get(timeout=PATIENCE_S)):
            assert event["stage"] in (Stage.REGIONS, Stage.ROUTE)
        assert event["failure"] == STOPPED
    finally:
        process.close()


def test_it_stops_at_once_and_leaves_nothing_open(quick_config: Config, tmp_path: Path) -> None:
    """Stopped before it has begun, it says the same; once closed, no file of this process is left of it."""
    file = tmp_path / "quick.yaml"
    file.write_text(dump_config(quick_config))
    before = set(Path("/proc/self/fd").iterdir())
    heard: SimpleQueue[dict[str, Any]] = SimpleQueue()
    process = Planning(file, tmp_path / "run", Stage.ROUTE, heard.put)
    process.stop()
    while "failure" not in (event := heard.get(timeout=PATIENCE_S)):
        assert event["stage"] == Stage.REGIONS
    assert event == {"failure": STOPPED}
    process.close()
    assert set(Path("/proc/self/fd").iterdir()) <= before
    assert heard.empty()


def test_a_process_that_breaks_is_reported(quick_config: Config, tmp_path: Path) -> None:
    """An end without a last word is a failure, with what the process wrote."""
    file = tmp_path / "quick.yaml"
    file.write_text(dump_config(quick_config))
    heard: SimpleQueue[dict[str, Any]] = SimpleQueue()
    process = Planning(file, tmp_path / "run", "no stage", heard.put)
    failure = heard.get(timeout=PATIENCE_S)["failure"]
    process.close()
    assert "planning ended unexpectedly" in failure
    assert "no stage" in failure


def test_a_failure_is_told(quick_config: Config, tmp_path: Path, vary) -> None:
    """A task that cannot be planned ends with its reason; a file that cannot be read, with its name."""
    file = tmp_path / "mine.yaml"
    same = {"task.goal": quick_config.task.start.model_dump(mode="json")}
    file.write_text(dump_config(vary(quick_config, same)))
    (end,) = events_of(file, tmp_path / "run", Stage.ROUTE)
    assert "task.goal: is the start itself" in end["failure"]
    (end,) = events_of(tmp_path / "none.yaml", tmp_path / "run", Stage.ROUTE)
    assert "none.yaml" in end["failure"]


@pytest.mark.slow
def test_a_route_is_planned(quick_config: Config, tmp_path: Path) -> None:
    """All went well: the last word is empty, and every stage has told its end."""
    file = tmp_path / "quick.yaml"
    file.write_text(dump_config(quick_config))
    *before, end = events_of(file, tmp_path / "run", Stage.ROUTE)
    assert end == {"failure": ""}
    assert [event["stage"] for event in before if event["message"].startswith("done")] == [Stage.REGIONS, Stage.ROUTE]
