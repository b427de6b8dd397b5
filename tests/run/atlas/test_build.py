"""Building an atlas: what is kept, what is found again, and what is refused."""

import fcntl
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.artifacts.atlas_record import read_atlas
from pipeline.atlas.record import AtlasRecord
from pipeline.config import Config
from pipeline.errors import ConfigError, NoSolutionError, UsageError
from pipeline.progress import Monitor
from pipeline.run import RunOptions, run_pipeline
from pipeline.run.atlas import AtlasOptions, make_atlas
from pipeline.run.product import Product
from pipeline.run.stage_specs import SPECS
from pipeline.stage import Stage
from tests.run.atlas.conftest import LEFT, LOW, RIGHT
from tests.run.fake_stages import FakeStages


def figures(record: AtlasRecord) -> list[dict]:
    """Give all of an atlas but for the time it took."""
    return [pair.model_dump(exclude={"seconds"}) for pair in record.pairs]


def searched(monitor_messages: list[str]) -> set[str]:
    """Give the pairs of which a monitor was told."""
    return {message.split(" (")[0] for message in monitor_messages if " to " in message and " of " in message}


def unsolved(*_: object) -> Product:
    """Refine nothing."""
    raise NoSolutionError("refine", "not converged", "give it more nodes")


class Listener:
    """Notes messages, and interrupts at one."""

    def __init__(self, interrupt_at: str = "nothing") -> None:
        self.messages: list[str] = []
        self._interrupt_at = interrupt_at

    def __call__(self, message: str, fraction: float | None = None) -> None:
        """Note a message."""
        self.messages.append(message)
        if self._interrupt_at in message:
            raise KeyboardInterrupt


@pytest.fixture(scope="session")
def whole(cell: Config, tmp_path_factory: pytest.TempPathFactory) -> tuple[AtlasRecord, Path]:
    """Make the atlas of all pairs."""
    folder = tmp_path_factory.mktemp("whole") / "atlas"
    return make_atlas(cell, folder), folder


def test_the_folder_has_every_pair(whole, cell: Config) -> None:
    """The record that is returned is the one on disk; every route has its table."""
    record, folder = whole
    assert read_atlas(folder) == record
    assert [(pair.origin, pair.target) for pair in record.pairs] == list(record.wanted())
    assert all((folder / pair.route).is_file() for pair in record.pairs)
    assert record.reversible
    assert sum(pair.from_reverse for pair in record.pairs) == 3
    assert record.problems() == []


def test_every_pair_has_the_figures_of_its_run(whole, cell: Config, tmp_path: Path) -> None:
    """`gantry-tau run --to route` of the pair's task finds as good a route."""
    record, _ = whole
    for pair in record.pairs[:3]:
        poses = {station.name: station.pose for station in record.stations}
        task = cell.task.model_copy(update={"start": poses[pair.origin], "goal": poses[pair.target]})
        report = run_pipeline(
            cell.model_copy(update={"task": task}), tmp_path / pair.name, RunOptions(last=Stage.ROUTE)
        )
        route = report.summary["route"]
        assert pair.objective == pytest.approx(route["objective"], rel=1e-9)
        assert (pair.status, pair.steps, pair.mode_changes) == (route["status"], route["steps"], route["mode_changes"])


def test_what_was_found_before_an_interrupt_is_kept(whole, cell: Config, tmp_path: Path) -> None:
    """The same call goes on where it ended, and ends with the same atlas."""
    with pytest.raises(KeyboardInterrupt):
        make_atlas(cell, tmp_path / "a", monitor=Monitor(Listener("left to low")))
    assert [pair.name for pair in read_atlas(tmp_path / "a").pairs] == ["left--right", "right--left"]
    listener = Listener()
    assert figures(make_atlas(cell, tmp_path / "a", monitor=Monitor(listener))) == figures(whole[0])
    assert searched(listener.messages) == {"left to low", "right to low"}
    again = Listener()
    make_atlas(cell, tmp_path / "a", monitor=Monitor(again))
    assert again.messages == []


def test_a_new_station_costs_its_own_pairs(whole, cell: Config, vary, tmp_path: Path) -> None:
    """Pairs of stations that stay as they are stay; those of one that moved move to `superseded`."""
    make_atlas(vary(cell, {"atlas.stations": [LEFT, RIGHT]}), tmp_path / "a")
    listener = Listener()
    assert figures(make_atlas(cell, tmp_path / "a", monitor=Monitor(listener))) == figures(whole[0])
    assert not searched(listener.messages) & {"left to right", "right to left"}
    moved = {"name": "low", "pose": LOW["pose"] | {"y_m": 0.4}}
    record = make_atlas(vary(cell, {"atlas.stations": [LEFT, RIGHT, moved]}), tmp_path / "a")
    assert record.pair("left", "right") == whole[0].pair("left", "right").model_copy(
        update={"seconds": record.pair("left", "right").seconds}
    )
    attic = tmp_path / "a" / "superseded" / "0001"
    assert sorted(file.name for file in (attic / "routes").glob("*.csv")) == [
        "left--low.csv",
        "low--left.csv",
        "low--right.csv",
        "right--low.csv",
    ]
    assert len(json.loads((attic / "atlas.json").read_text())["pairs"]) == 6


def test_a_damaged_route_is_found_again(whole, cell: Config, tmp_path: Path) -> None:
    """A record without its route does not count; here the opposite pair has it."""
    make_atlas(cell, tmp_path / "a")
    (tmp_path / "a" / "routes" / "left--low.npz").write_bytes(b"nothing")
    listener = Listener()
    again = make_atlas(cell, tmp_path / "a", monitor=Monitor(listener)).pair("left", "low")
    assert again.model_copy(update={"from_reverse": False, "seconds": 0.0}) == whole[0].pair("left", "low").model_copy(
        update={"seconds": 0.0}
    )
    assert (tmp_path / "a" / "routes" / "left--low.npz").stat().st_size > 1_000
    assert len(listener.messages) > 0
    assert searched(listener.messages) == set()


def test_open_pairs_are_searched_again_with_more_time(whole, cell: Config, vary, tmp_path: Path) -> None:
    """Not with the same: they would end as before; what is proven stays whatever the time."""
    short = vary(cell, {"route.time_limit_s": 1e-9})
    record = make_atlas(short, tmp_path / "a")
    assert {pair.status for pair in record.pairs} == {"time limit"}
    assert record.problems() == list(record.pairs)
    assert all("no route was found within" in pair.reason for pair in record.pairs)
    listener = Listener()
    assert figures(make_atlas(short, tmp_path / "a", monitor=Monitor(listener))) == figures(record)
    assert listener.messages == []
    assert figures(make_atlas(cell, tmp_path / "a")) == figures(whole[0])
    make_atlas(short, tmp_path / "a", monitor=Monitor(listener))
    assert listener.messages == []


def test_force_finds_everything_again(whole, cell: Config, tmp_path: Path) -> None:
    """With the same result."""
    make_atlas(cell, tmp_path / "a")
    listener = Listener()
    again = make_atlas(cell, tmp_path / "a", AtlasOptions(force=True), Monitor(listener))
    assert figures(again) == figures(whole[0])
    assert len(searched(listener.messages)) == 3


def test_motions_are_runs(cell: Config, stages: FakeStages, tmp_path: Path) -> None:
    """One run per two opposite pairs, from regions and route of the atlas; the way back is the run, backwards."""
    options = AtlasOptions(Stage.RETIME, specs=stages.specs)
    record = make_atlas(cell, tmp_path / "a", options)
    there, back = record.pair("left", "low"), record.pair("low", "left")
    assert there.motion.run == back.motion.run == "runs/left--low"
    assert (there.motion.backwards, back.motion.backwards) == (False, True)
    assert there.motion.verdict == "certified"
    summary = json.loads((tmp_path / "a" / "runs" / "left--low" / "summary.json").read_text())
    assert there.motion.duration_s == summary["trajectory"]["duration_s"]
    assert back.motion.duration_s == summary["trajectory"]["back"]["duration_s"]
    assert there.motion.kappa_bound == summary["certificate"]["kappa_bound"]
    assert len(stages.calls) == 3 * 5
    make_atlas(cell, tmp_path / "a", options)
    assert len(stages.calls) == 3 * 5


def test_a_run_has_the_route_of_the_atlas(cell: Config, tmp_path: Path) -> None:
    """Neither is searched again, though the atlas had routes only, without what guides stage two."""
    make_atlas(cell, tmp_path / "a")
    specs = tuple(spec if spec.stage is not Stage.REFINE else replace(spec, make=unsolved) for spec in SPECS)
    listener = Listener()
    make_atlas(cell, tmp_path / "a", AtlasOptions(Stage.REFINE, specs=specs), Monitor(listener))
    assert searched(listener.messages) == set()
    run = tmp_path / "a" / "runs" / "left--right"
    found, given = (np.load(file) for file in (tmp_path / "a" / "routes" / "left--right.npz", run / "route.npz"))
    np.testing.assert_array_equal(found["pose"], given["pose"])
    assert np.isinf(found["search_least_kappa_max"])
    assert np.isfinite(given["search_least_kappa_max"])


def test_a_motion_that_fails_says_why(cell: Config, stages: FakeStages, tmp_path: Path) -> None:
    """The routes stay, and the pair is open."""
    stages.failures["refine"] = NoSolutionError("refine", "not converged", "give it more nodes")
    record = make_atlas(cell, tmp_path / "a", AtlasOptions(Stage.RETIME, specs=stages.specs))
    motion = record.pair("right", "left").motion
    assert (motion.status, motion.to, motion.reason) == ("failed", "refine", "not converged")
    assert len(record.problems()) == 6
    assert all(pair.status == "optimal" for pair in record.pairs)
    routes = make_atlas(cell, tmp_path / "a", AtlasOptions(specs=stages.specs))
    assert [pair.motion for pair in routes.pairs] == [pair.motion for pair in record.pairs]
    assert routes.problems() == []


def test_motions_of_another_configuration_go(cell: Config, stages: FakeStages, vary, tmp_path: Path) -> None:
    """A motion stays, there and backwards, while nothing of its own stages changes; the routes stay where they are."""
    two = vary(cell, {"atlas.stations": [LEFT, LOW]})
    record = make_atlas(two, tmp_path / "a", AtlasOptions(Stage.CERTIFY, specs=stages.specs))
    assert [pair.motion.backwards for pair in record.pairs] == [False, True]
    routes = AtlasOptions(specs=stages.specs)
    slower = vary(two, {"retime.speed": 0.5})
    assert make_atlas(slower, tmp_path / "a", routes).pairs == record.pairs
    sharper = vary(slower, {"certify.kappa_excess": 0.001})
    without = tuple(pair.model_copy(update={"motion": None}) for pair in record.pairs)
    assert make_atlas(sharper, tmp_path / "a", routes).pairs == without
    assert not (tmp_path / "a" / "superseded").exists()


def test_a_station_out_of_reach_is_refused(cell: Config, vary, tmp_path: Path) -> None:
    """Before anything is written."""
    far = {"name": "far", "pose": LOW["pose"] | {"x_m": 4.0}}
    with pytest.raises(ConfigError, match=r"atlas\.stations\[1\]"):
        make_atlas(vary(cell, {"atlas.stations": [LEFT, far]}), tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_a_folder_of_something_else_is_refused(cell: Config, tmp_path: Path) -> None:
    """And left as it is."""
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(UsageError, match="no atlas"):
        make_atlas(cell, tmp_path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["notes.txt"]


def test_one_process_at_a_time(cell: Config, whole, tmp_path: Path) -> None:
    """A second one is refused."""
    make_atlas(cell, tmp_path / "a")
    with (tmp_path / "a" / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(UsageError, match="another run"):
            make_atlas(cell, tmp_path / "a")


@pytest.mark.parametrize("content", ["", "{}", '{"name": 1}', "[" * 100_000])
def test_a_damaged_atlas_is_refused(content: str, cell: Config, tmp_path: Path) -> None:
    """With what to do about it."""
    (tmp_path / "atlas.json").write_text(content)
    with pytest.raises(UsageError, match=r"damaged.*\n.*move it away"):
        make_atlas(cell, tmp_path)
