"""Optimisations: the same cases for the same seed, whoever runs them and however often they are interrupted."""

import contextlib
import random
from pathlib import Path
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.errors import PipelineError, UsageError
from pipeline.progress import QUIET
from pipeline.study.cases import Case, Cases
from pipeline.study.engine import Engine, Setting
from pipeline.study.optimise.trials import Optimiser, ended_cases, source_of
from pipeline.study.rows import Ending, Row
from pipeline.study.store import Store
from pipeline.study.table import Table, build_table
from tests.study.fakes import Answer, FakeClient, cases_of

LENGTH, TILT = "machine.links.l1.length_m", "task.tilt_max_deg"
SAMPLERS = pytest.mark.parametrize("sampler", ["tpe", "nsga2"])


def optimise(folder: Path, config: Config, sampler: str = "tpe", **keys: Any) -> Cases:
    """Make an optimisation of a length and a tilt limit; the configuration as it is lies in its ranges."""
    design = {"kind": "optimise", "sampler": sampler, "samples": 24, "initial": 6, "parallel": 3, "seed": 5}
    design |= keys.pop("design", {})
    parameters = [{"key": LENGTH, "min": 1.0, "max": 1.2}, {"key": TILT, "values": [10, 20, 30]}]
    whole = {"parameters": parameters, "pareto": ["-space", "path.kappa_max"], **keys}
    return cases_of(folder, config, design=design, **whole)


def result(request: dict[str, Any]) -> dict[str, Any]:
    """Answer with figures that contradict each other; tilts of 10 degrees have no route."""
    length, tilt = request["data"]["machine"]["links"]["l1"]["length_m"], request["data"]["task"]["tilt_max_deg"]
    if tilt == 10:
        return {"row": Row(request["key"], Ending.NO_SOLUTION.value, "no route").data()}
    figures = {"space": length * tilt, "path.kappa_max": 20.0 + 1e3 * (length - 1.1) ** 2 + tilt}
    return {"row": Row(request["key"], Ending.DONE.value, figures=figures).data()}


def row_of(case: Case) -> Row:
    """Make the row of a case as the workers do."""
    return Row.read(result({"key": case.key, "data": case.data})["row"])


def lead(folder: Path, cases: Cases, client: FakeClient) -> Table:
    """Lead a study; return its table."""
    folder.mkdir(exist_ok=True)
    setting = Setting(folder, cases.study.to, cases.program, cases.study.run)
    with Store(folder) as store:
        with contextlib.suppress(PipelineError):
            Engine(setting, client.pool, store, len(cases), QUIET).lead(source_of(cases))
        return build_table(cases, store)


def until_lost(client: FakeClient) -> Answer:
    """Answer four requests; then the scheduler is gone."""
    return lambda request: {"lost": True} if len(client.asked) > 4 else result(request)


def run_out_of_order(cases: Cases, seed: int) -> list[dict[str, Any]]:
    """Run an optimisation on workers of which any may be the next to end; return its points."""
    source, pick, running, points = Optimiser(cases), random.Random(seed), list[Case](), dict[int, Any]()
    while True:
        while (case := source.ask()) is not None:
            running.append(case)
            points[case.number] = case.point
        assert len(running) <= cases.study.design.parallel
        if not running:
            return [points[number] for number in sorted(points)]
        case = running.pop(pick.randrange(len(running)))
        source.tell(case, row_of(case))


@SAMPLERS
def test_the_same_seed_gives_the_same_table(tmp_path: Path, quick_config: Config, sampler: str) -> None:
    """Another seed gives another; all runs are there, the first of them the configuration as it is."""
    cases = optimise(tmp_path, quick_config, sampler)
    table = lead(tmp_path / "a", cases, FakeClient(result))
    assert table == lead(tmp_path / "b", cases, FakeClient(result))
    assert table.columns["number"] == list(range(1, 25))
    assert table.columns[LENGTH][0] == quick_config.machine.links.l1.length_m
    assert table.columns[TILT][0] == quick_config.task.tilt_max_deg
    other = optimise(tmp_path, quick_config, sampler, design={"seed": 6})
    assert table.columns[LENGTH][1:] != lead(tmp_path / "c", other, FakeClient(result)).columns[LENGTH][1:]


@SAMPLERS
def test_points_do_not_depend_on_which_run_ends_first(tmp_path: Path, quick_config: Config, sampler: str) -> None:
    """Each is chosen by the results of all runs but the last few before it, also where the sampler repeats itself."""
    parameters = [{"key": LENGTH, "values": [1.0, 1.09, 1.2]}, {"key": TILT, "values": [10, 20, 30]}]
    for keys in ({}, {"parameters": parameters}):
        cases = optimise(tmp_path, quick_config, sampler, **keys)
        first = run_out_of_order(cases, seed=0)
        assert all(run_out_of_order(cases, seed) == first for seed in (1, 2))


@SAMPLERS
def test_an_interrupted_optimisation_goes_on(tmp_path: Path, quick_config: Config, sampler: str) -> None:
    """After any number of runs: nothing is run twice, and the table is that of a calm study."""
    cases, asked = optimise(tmp_path, quick_config, sampler), list[str]()
    calm = lead(tmp_path / "calm", cases, FakeClient(result))
    for _ in range(9):
        client = FakeClient(result)
        client.answer = until_lost(client)
        table = lead(tmp_path / "killed", cases, client)
        asked += client.asked[:4]
    assert table == calm
    assert sorted(set(asked)) == sorted(asked)


@SAMPLERS
def test_it_finds_better_values_than_it_began_with(tmp_path: Path, quick_config: Config, sampler: str) -> None:
    """One objective of a parabola: the best run is within a twentieth of the range."""
    cases = optimise(
        tmp_path,
        quick_config,
        sampler,
        pareto=["path.kappa_max"],
        parameters=[{"key": LENGTH, "min": 1.0, "max": 1.2}, {"key": TILT, "values": [20]}],
        design={"samples": 60},
    )
    table = lead(tmp_path / "a", cases, FakeClient(result))
    best = min(zip(table.columns["path.kappa_max"], table.columns[LENGTH], strict=True))
    assert abs(best[1] - 1.1) < 0.01


@SAMPLERS
def test_samplers_learn_where_runs_fail(tmp_path: Path, quick_config: Config, sampler: str) -> None:
    """A third of all points has no route, and less than a quarter of those chosen late."""
    cases = optimise(tmp_path, quick_config, sampler, design={"samples": 60, "initial": 10})
    failed = [reason is not None for reason in lead(tmp_path / "a", cases, FakeClient(result)).columns["reason"]]
    assert any(failed)
    assert sum(failed[30:]) < 30 / 4


def test_constraints_are_kept(tmp_path: Path, quick_config: Config) -> None:
    """Runs beyond a bound are done, do not count, and have the bound as their reason."""
    bound = [{"figure": "path.kappa_max", "max": 45.0}]
    table = lead(tmp_path / "a", optimise(tmp_path, quick_config, constraints=bound), FakeClient(result))
    broken = [kappa is not None and kappa > 45.0 for kappa in table.columns["path.kappa_max"]]
    reasons = table.columns["reason"]
    assert [reason == "path.kappa_max above 45" for reason in reasons] == broken
    assert set(reasons) == {None, "no route", "path.kappa_max above 45"}


def test_a_figure_that_no_run_has_is_refused(tmp_path: Path, quick_config: Config) -> None:
    """At the first result, with its place in the file and what is near; the table can be made all the same."""
    cases = optimise(tmp_path, quick_config, pareto=["path.kapa_max"])
    source = Optimiser(cases)
    case = source.ask()
    assert case is not None
    with pytest.raises(UsageError, match=r"pareto\[0\]: .* no number path.kapa_max: near it are path.kappa_max"):
        source.tell(case, row_of(case))
    with Store(tmp_path) as store:
        store.add(row_of(case))
        assert [row.key for _, row in ended_cases(cases, store)] == [case.key]
        assert build_table(cases, store).columns["reason"] == ["no path.kapa_max"]
