"""Leading a study: nothing is lost, nothing is done twice."""

from pathlib import Path
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.errors import PipelineError, UsageError
from pipeline.progress import Monitor
from pipeline.study.cases import Cases
from pipeline.study.engine import MOST_DEATHS, RUNS, Engine, Fixed, Setting
from pipeline.study.rows import Ending, Row
from pipeline.study.store import Store
from pipeline.study.worker.task import failed_row, keep_row
from tests.study.fakes import FakeClient, cases_of, done


def lead(folder: Path, cases: Cases, client: FakeClient, retry: bool = False) -> list[str]:
    """Lead a study; return what was said on the way."""
    said: list[str] = []
    monitor = Monitor(lambda message, fraction=None: said.append(message))
    setting = Setting(folder, cases.study.to, cases.program, cases.study.run, retry)
    with Store(folder) as store:
        Engine(setting, client.pool, store, len(cases), monitor).lead(Fixed(iter(cases)))
    return said


def endings(folder: Path) -> list[str]:
    """List how runs ended."""
    with Store(folder) as store:
        return sorted(row.ending for row in store.rows())


def test_every_case_is_run_once(tmp_path: Path, quick_config: Config) -> None:
    """All rows are kept; the same study once more asks nobody, and needs no workers."""
    cases, client = cases_of(tmp_path, quick_config), FakeClient(done)
    said = lead(tmp_path, cases, client)
    assert client.asked == [case.key for case in cases]
    assert said[-1].startswith("3 of 3 runs")
    idle = FakeClient(done, memory_gb=0.0)
    lead(tmp_path, cases, idle)
    assert idle.asked == []


def test_what_was_done_stays_done_when_the_scheduler_is_lost(tmp_path: Path, quick_config: Config) -> None:
    """The client says how many runs are kept, and takes up the rest when it starts again."""
    cases = cases_of(tmp_path, quick_config)
    second = list(cases)[1].key
    broken = FakeClient(lambda request: {"lost": True} if request["key"] == second else done(request))
    with pytest.raises(PipelineError, match=r"is gone\. 1 runs are done, and kept"):
        lead(tmp_path, cases, broken)
    client = FakeClient(done)
    lead(tmp_path, cases, client)
    assert client.asked == [case.key for case in cases][1:]


def test_a_run_that_ends_its_process_is_marked_and_left(tmp_path: Path, quick_config: Config) -> None:
    """It has three attempts, also over several starts, and another three on request."""
    cases, deadly = cases_of(tmp_path, quick_config), FakeClient(lambda request: {"ended": "by SIGKILL"})
    lead(tmp_path, cases, deadly)
    assert len(deadly.asked) == MOST_DEATHS * len(cases)
    assert endings(tmp_path) == [Ending.KILLED] * 3
    lead(tmp_path, cases, idle := FakeClient(done))
    assert idle.asked == []
    lead(tmp_path, cases, retried := FakeClient(done), retry=True)
    assert len(retried.asked) == 3
    assert endings(tmp_path) == [Ending.DONE] * 3


class KilledWorker(Exception):  # noqa: N818  # Dask's own name
    """What Dask raises where the worker itself has ended too often."""


@pytest.mark.parametrize(("error", "ending"), [(KilledWorker(), Ending.KILLED), (OSError("full"), Ending.ERROR)])
def test_a_worker_without_an_answer(tmp_path: Path, quick_config: Config, error: Exception, ending: Ending) -> None:
    """Its runs are marked, and the study goes on."""
    lead(tmp_path, cases_of(tmp_path, quick_config), FakeClient(lambda request: {"raised": error}))
    assert endings(tmp_path) == [ending] * 3


def test_a_longer_time_limit_runs_again_what_it_stopped(tmp_path: Path, quick_config: Config) -> None:
    """And nothing else: with the same limit it is final."""

    def stopped(request: dict[str, Any]) -> dict[str, Any]:
        return {"row": failed_row(request, Ending.TIME_LIMIT, "", 1.0).data()}

    cases = cases_of(tmp_path, quick_config, run={"time_limit_s": 5})
    lead(tmp_path, cases, FakeClient(stopped))
    lead(tmp_path, cases, same := FakeClient(done))
    lead(tmp_path, cases_of(tmp_path, quick_config, run={"time_limit_s": 50}), more := FakeClient(done))
    assert (len(same.asked), len(more.asked)) == (0, 3)


def test_another_program_is_refused_with_both_versions(tmp_path: Path, quick_config: Config) -> None:
    """A worker that joins later, too."""
    with pytest.raises(UsageError, match=r"has 0.0.9, this is 1: "):
        lead(tmp_path, cases_of(tmp_path, quick_config), FakeClient(lambda request: {"other": "0.0.9"}))


def test_too_little_memory_is_said(tmp_path: Path, quick_config: Config) -> None:
    """Nobody waits for a worker that will never be large enough."""
    with pytest.raises(UsageError, match=r"needs 4.2 GB, and the largest worker has 1.0 GB"):
        lead(tmp_path, cases_of(tmp_path, quick_config), FakeClient(done, memory_gb=1.0))


def test_a_run_that_is_too_large_is_said_while_others_run(tmp_path: Path, quick_config: Config) -> None:
    """It is counted for itself: the room for those before it is not the room for it."""
    sizes = {"parameters": [{"key": "route.memory_gb", "values": [2, 500]}]}
    with pytest.raises(UsageError, match=r"needs 500.2 GB, and the largest worker has 64.0 GB"):
        lead(tmp_path, cases_of(tmp_path, quick_config, **sizes), FakeClient(done))


def planned(request: dict[str, Any]) -> dict[str, Any]:
    """Answer as `done`, and leave a run folder as a worker does."""
    folder, answer = Path(request["folder"]), done(request)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "regions.npz").touch()
    keep_row(request, Row.read(answer["row"]))
    return answer


def test_a_folder_is_cleared_after_the_last_run_that_has_it(tmp_path: Path, quick_config: Config) -> None:
    """Twins that wait find the motion, whatever is kept; in the end there are rows alone."""
    found: list[bool] = []

    def answer(request: dict[str, Any]) -> dict[str, Any]:
        found.append((Path(request["folder"]) / "regions.npz").exists())
        return planned(request)

    seeds = {"parameters": [{"key": "twin.seed", "values": [1, 2, 3]}], "to": "simulate", "run": {"keep": "none"}}
    lead(tmp_path, cases_of(tmp_path, quick_config, **seeds), FakeClient(answer))
    assert found == [False, True, True]
    assert [path.name[:4] for path in (tmp_path / RUNS).glob("*/*")] == ["row-"] * 3


def test_a_folder_that_was_not_cleared_is_at_the_next_start(tmp_path: Path, quick_config: Config) -> None:
    """After a kill between the row and the clearing, whether the row has reached the store or not."""
    lead(tmp_path, cases_of(tmp_path, quick_config), FakeClient(planned))
    (tmp_path / "study.sqlite").unlink()
    assert len(list((tmp_path / RUNS).glob("*/regions.npz"))) == 3
    lead(tmp_path, cases_of(tmp_path, quick_config, run={"keep": "failed"}), idle := FakeClient(done))
    assert idle.asked == []
    assert not list((tmp_path / RUNS).glob("*/regions.npz"))


def test_a_folder_of_a_run_that_ended_its_process_is_kept_where_failed_ones_are(
    tmp_path: Path, quick_config: Config
) -> None:
    """Its row is there, too."""

    def deadly(request: dict[str, Any]) -> dict[str, Any]:
        planned(request)
        return {"ended": "by SIGKILL"}

    lead(tmp_path, cases_of(tmp_path, quick_config, run={"keep": "failed"}), FakeClient(deadly))
    assert len(list((tmp_path / RUNS).glob("*/regions.npz"))) == 3


def test_a_motion_is_planned_once_for_all_twins(tmp_path: Path, quick_config: Config) -> None:
    """Runs in the same folder wait for the first of them, and all have a row."""
    seeds = {"parameters": [{"key": "twin.seed", "values": [1, 2, 3]}], "to": "simulate"}
    cases, client = cases_of(tmp_path, quick_config, **seeds), FakeClient(done)
    lead(tmp_path, cases, client)
    assert sorted(client.asked) == sorted(case.key for case in cases)
