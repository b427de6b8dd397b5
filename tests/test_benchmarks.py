"""The benchmark's own machinery: what it measures on a tiny case, how it judges answers, and the page it writes."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from pipeline.config.file import load_config
from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route
from pipeline.route.regions.endpoints import task_endpoints
from tests.benchmarks import bodies, cli, obstacles, report, side_by_side
from tests.benchmarks.growth import growth
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.peers.ours import place_along_x
from tests.benchmarks.problems import CONFIGS, Problem, ladder, scale_problems
from tests.benchmarks.side_by_side import METHODS, Method, compare, headline

ROOT = Path(__file__).parents[1]
TASKS = """
import os, signal, time

def finishes():
    yield {"first": 1}
    yield {"second": 2}

def fails():
    yield {"first": 1}
    raise ArithmeticError

def lingers():
    yield {"first": 1}
    time.sleep(60)

def dies():
    yield {"first": 1}
    os.kill(os.getpid(), signal.SIGKILL)

def jumps(folder, limit_s):
    import numpy as np
    with np.load(folder / "regions.npz") as table:
        count = len(table["kappa"])
    yield {"status": "optimal", "seconds": 0.1, "rows": np.array([count - 2, count - 1]), "x_m": np.full(2, 1.02)}

def dawdles(folder, limit_s):
    yield {"status": "optimal", "seconds": 2 * limit_s, "bound": 0.0}
"""


@pytest.fixture(autouse=True)
def importable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let processes of their own find the benchmark and, as module `tasks`, the tasks above."""
    (tmp_path / "tasks.py").write_text(TASKS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(ROOT)


def test_benchmark_writes_a_table_and_the_same_figures_as_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tiny run ends with every method named, all optima equal, well-formed JSON and well-formed tables."""
    config = ladder()[0].config
    once = config.model_copy(update={"route": config.route.model_copy(update={"max_rounds": 1})})
    monkeypatch.setattr(cli, "scale_problems", lambda: [Problem("tiny", once)])
    monkeypatch.setattr(cli, "finer_problems", lambda: [Problem("tiny", once)])
    monkeypatch.setattr(side_by_side, "METHODS", METHODS[:3])
    monkeypatch.setattr(report, "METHODS", METHODS[:3])
    cli.benchmark(out=tmp_path, case_limit_s=60.0, peer_limit_s=1.0, cases=1, rungs=1, grids=2)
    results = json.loads((tmp_path / "route.json").read_text())
    case, instance = results["cases"][0], results["instances"][0]
    assert case["ended"] == FINISHED
    assert case["nominal_variables"] == (13 + case["regions"]) * case["step_budget"]
    assert case["total_s"] == pytest.approx(sum(case[p] for p in ("regions_s", "moves_s", "relaxation_s", "solve_s")))
    assert case["objective"] <= case["threshold"] * (1 + 1e-9)
    assert 10.0 < case["peak_mb"] < 2_000.0
    assert "forbidden" in case["not_followed"]
    assert list(instance["methods"]) == ["core", "Dijkstra", "compact, HiGHS"]
    assert instance["methods"]["core"]["status"] == "optimal"
    assert instance["optimum"] == pytest.approx(case["objective"], rel=1e-9)
    assert instance["methods"]["Dijkstra"]["objective"] == pytest.approx(instance["optimum"], rel=1e-9)
    assert instance["agree"]
    study = results["resolution"]
    assert study["reference"][0]["relaxation"] == pytest.approx(case["relaxation"], rel=1e-9)
    assert study["reference_exponent"] is None
    assert study["level"][1]["bottleneck"] > 1.3 * study["level"][0]["bottleneck"]
    assert results["host"]["cores"] >= 1
    page = (tmp_path / "route.md").read_text()
    tables = re.findall(r"(?:^\|.*\|\n)+", page, flags=re.MULTILINE)
    assert len(tables) >= 5
    for table in tables:
        lines = table.splitlines()
        assert len({line.count("|") for line in lines}) == 1
        assert set(lines[1]) <= set("|- ")
        assert len(lines) >= 3


def test_a_wrong_or_a_late_answer_does_not_count_as_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A peer that breaks the rules makes the methods disagree; one that comes too late is not tried again."""
    liar, dawdler = Method("liar", "tasks:jumps"), Method("dawdler", "tasks:dawdles")
    monkeypatch.setattr(side_by_side, "METHODS", (liar, dawdler))
    first, second = compare(ladder()[:1] * 2, 60.0, lambda _: None)
    assert not first["agree"]
    assert first["methods"]["liar"]["broken"]
    assert first["methods"]["dawdler"]["status"].startswith("too late")
    assert second["methods"]["dawdler"]["status"] == f"not tried, not solved with {first['regions']} regions"


@pytest.fixture(scope="module")
def found() -> dict[str, Any]:
    """Let every peer that is installed look for the optimum of the smallest problem, and the core."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT)
        patch.setattr(side_by_side, "METHODS", (METHODS[0], *METHODS[2:-1]))
        (instance,) = compare(ladder()[:1], 60.0, lambda _: None)
    return instance


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS[2:-1], ids=lambda method: method.name)
def test_every_peer_finds_the_optimum_of_the_core(method: Method, found: dict[str, Any]) -> None:
    """The smallest problem has one optimum, whichever solver looks for it and whatever its numbers are."""
    if found["methods"][method.name]["status"].endswith("not installed"):
        pytest.skip(found["methods"][method.name]["status"])
    assert found["methods"][method.name]["status"] == "optimal"
    assert found["agree"]


def test_headline_compares_on_the_largest_problem_a_peer_solves() -> None:
    """The ratio is the best peer's seconds over the core's, on the largest contested problem and its worst variant."""

    def instance(regions: int, core_s: float, *peers: float | None) -> dict[str, object]:
        names = ("compact, HiGHS", "compact, SCIP")
        solved = [{"status": "time limit"} if s is None else {"status": "optimal", "seconds": s} for s in peers]
        methods = {"core": {"status": "optimal", "seconds": core_s}, "Dijkstra": {"status": "optimal", "seconds": 0.0}}
        return {"name": f"{regions}", "regions": regions, "methods": methods | dict(zip(names, solved, strict=True))}

    found = headline(
        [
            instance(10, 0.1, 1.0, 2.0),
            instance(20, 0.1, 30.0, 20.0),
            instance(20, 0.1, 40.0, None),
            instance(30, 1, None, None),
        ]
    )
    assert found is not None
    assert (found["regions"], found["best_peer"]) == (20, "compact, SCIP")
    assert found["ratio"] == pytest.approx(200.0)
    assert headline([instance(10, 0.1, None, None)]) is None


@pytest.mark.parametrize(
    ("task", "limit_s", "ending"),
    [
        ("finishes", 30.0, FINISHED),
        ("fails", 30.0, "failed"),
        ("lingers", 2.0, "not finished"),
        ("dies", 30.0, "killed"),
    ],
)
def test_figures_survive_however_a_measurement_ends(task: str, limit_s: float, ending: str) -> None:
    """What was told before the end is kept, and the ending is named."""
    measured = measure(f"tasks:{task}", (), limit_s)
    assert measured.ended.startswith(ending)
    assert measured.figures["first"] == 1


def test_a_solver_that_is_not_installed_is_named() -> None:
    """A missing extra is a result, not a failure."""
    measured = measure("no_such_solver:compact", (), 30.0)
    assert measured.ended == FINISHED
    assert measured.figures == {"status": "no_such_solver is not installed"}


@given(st.floats(0.2, 3.0), st.floats(1e-8, 1e-3))
def test_growth_recovers_a_power_law(exponent: float, factor: float) -> None:
    """Seconds that follow a power law give its exponent; a part that no two cases finished is left out."""
    cases = [{"regions": n, "moves_s": factor * n**exponent} for n in (900, 4_000, 70_000)]
    cases[0]["relaxation_s"] = 1.0
    found = growth(cases)
    assert set(found) == {"moves_s"}
    assert found["moves_s"]["exponent"] == pytest.approx(exponent, abs=1e-9)


def test_n_log_n_is_the_unit_of_growth() -> None:
    """Seconds proportional to n log n give ones, in whatever order the cases come."""
    found = growth([{"regions": n, "total_s": 1e-6 * n * np.log(n)} for n in (70_000, 900, 4_000)])
    np.testing.assert_allclose(found["total_s"]["n_log_n"], 1.0)
    assert found["total_s"]["regions"] == [900, 4_000, 70_000]


@given(st.lists(st.tuples(st.floats(0, 2), st.floats(0, 0.5)), min_size=1, max_size=8), st.floats(0.05, 0.5))
def test_x_is_placed_wherever_a_linear_program_can(windows: list[tuple[float, float]], step: float) -> None:
    """X is found exactly when a linear program finds one, within its windows and its step."""
    limits = np.array([(low, low + width) for low, width in windows])
    change = np.diff(np.eye(len(limits)), axis=0)
    program = linprog(
        np.zeros(len(limits)), np.vstack([change, -change]), np.full(2 * len(change), step), bounds=limits
    )
    x = place_along_x(limits, step)
    if x is None:
        tight = linprog(
            np.zeros(len(limits)), np.vstack([change, -change]), np.full(2 * len(change), step - 1e-6), bounds=limits
        )
        assert not tight.success
        return
    assert program.success
    assert ((x >= limits[:, 0]) & (x <= limits[:, 1])).all()
    assert (np.abs(np.diff(x)) <= step + 1e-12).all()


def test_the_reference_task_is_among_the_problems_and_names_tell_them_apart() -> None:
    """One of the grids is that of the reference configuration itself, and no name stands for two problems."""
    scale, rungs = scale_problems(), ladder()
    assert load_config(CONFIGS / "agder.yaml") in [problem.config for problem in scale]
    assert len({problem.name for problem in scale}) == len(scale)
    assert len({problem.name for problem in rungs}) == len(rungs)


@pytest.mark.slow
def test_paper_size_is_the_papers() -> None:
    """The grid has the paper's 45,936 regions within 2 %, N is 25, and there is a proven route."""
    config = load_config(CONFIGS / "paper.yaml")
    machine = build_machine(config.machine)
    regions = build_regions(config, machine)
    assert len(regions) == pytest.approx(45_936, rel=0.02)
    assert config.route.step_budget == 25
    route = plan_route(config, machine, regions)
    assert route.search.gap == 0.0
    assert len(route) <= 25


def test_tasks_with_obstacles_are_drawn_with_clear_ends_or_with_why_not() -> None:
    """Start and goal of a task keep clear; a drawn task that is left out names the end and the pair."""
    drawn = list(obstacles.obstacle_tasks(1, seed=7))
    *refused, task = drawn
    assert isinstance(task, Problem)
    assert task.config.task.obstacles
    task_endpoints(task.config, build_machine(task.config.machine))
    assert refused
    for one in refused:
        assert isinstance(one, obstacles.Refused)
        assert re.match(r"task\.(start|goal): has .* and obstacle\d", one.reason)


def test_the_page_of_bodies_says_how_tasks_ended_and_what_bodies_cost() -> None:
    """Certified with distances, none with what opens a route, ratios as medians of rounds."""
    ends = {"seconds": 12.0, "objective": 455.5, "modes": "LLL LLL RRR"}
    certified = {"task": "a", "outcome": "certified", "boxes": 40, "proven_m": 0.0051, "nearest_m": 0.0055, **ends}
    certified |= {"refused_claims": [], "below": [], "asked": 4_000, "pairs": 300}
    none = {"task": "b", "outcome": "no route, proven", "reason": "no route exists", "opens": ["without x: a route"]}
    stages = dict.fromkeys(("regions", "route", "refine", "certify", "retime", "figures"), 1.0)
    tables = [{"without": 2.0, "with": 2.0 * ratio} for ratio in (3.0, 5.0, 4.0)]
    runs = [
        {case: {"wall_s": 20.0, "cpu_s": cpu, "stages": stages} for case, cpu in (("without", 30.0), ("with", 60.0))}
    ]
    refused = [{"task": "c", "reason": "task.start: has link 1 and o", "nearest_m": -0.001}]
    host = {"cpu": "one", "cores": 2, "date": "today", "load_before": 0.5}
    found = {"host": host, "tasks": [certified, none], "refused": refused, "coal": True, "samples": 100_000}
    page = bodies.page({**found, "tables": tables, "runs": runs})
    assert "Of 2 tasks: 1 certified, 1 no route, proven." in page
    assert "| 1 | a | 12 | certified | 455.50, LLL RRR | 40 | 5.10 | 5.50 | 4,000 |" in page
    assert "- Task 2: no route exists.\n  - without x: a route" in page
    assert "of 300 pairs of bodies 0 came nearer than is proven" in page
    assert "| region table, with bodies to without | 3 | 4.00 | 3.00 | 5.00 | 4 |" in page
    assert "| whole run, with bodies to without | 1 | 2.00 | 2.00 | 2.00 | 2.5 |" in page
    assert "before there were any" not in page
    assert "whole run" not in bodies.page({**found, "tables": tables, "runs": []})
    assert "Skipped: coal is not installed" in bodies.page({**found, "coal": False})
