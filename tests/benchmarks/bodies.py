"""What bodies cost, and what comes of random obstacles: `make bench-bodies`."""

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import typer

from pipeline.artifacts import json_bytes, write_whole
from tests.benchmarks.host import describe_host
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.obstacles import HAS_COAL, SAMPLES, Refused, obstacle_tasks
from tests.benchmarks.problems import Problem
from tests.benchmarks.report import table
from tests.benchmarks.whole_runs import ROOT
from tests.benchmarks.whole_runs import measure as measure_runs

_OUT = ROOT / "results" / "benchmarks"
_WITHOUT, _WITH = "agder", "agder-bodies"
_TABLE = """
import sys, time
from pipeline.config.file import load_config
from pipeline.machine import build_machine
from pipeline.route import build_regions
config = load_config(sys.argv[1])
machine = build_machine(config.machine)
began = time.process_time()
build_regions(config, machine)
print(time.process_time() - began)
"""
_ASKED = {"regions": 4.0, "run": 2.5, "before": 1.05}
"""Largest ratios that are asked for."""


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for bodies.json and bodies.md")] = _OUT,
    tasks: Annotated[int, typer.Option(min=0, help="random tasks")] = 20,
    rounds: Annotated[int, typer.Option(min=0, help="runs of each kind")] = 3,
    resume: Annotated[bool, typer.Option("--resume", help="keep what bodies.json has, and measure the rest")] = False,
    tree: Annotated[Path | None, typer.Option(help="a checkout from before there were bodies")] = None,
    limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each task")] = 1_800.0,
) -> None:
    """Plan, certify and check random tasks with obstacles; compare runs with bodies and without."""
    file = out / "bodies.json"
    before: dict[str, Any] = json.loads(file.read_text(encoding="utf-8")) if resume and file.exists() else {}
    known = before.get("tasks", [])
    found = {"host": describe_host(), "coal": HAS_COAL, "samples": SAMPLES, "tasks": [], "refused": []}
    found["runs"] = before.get("runs", [])[:rounds]

    def keep() -> None:
        write_whole(file, json_bytes(found))
        write_whole(out / "bodies.md", page(found).encode())

    for problem in obstacle_tasks(tasks):
        if isinstance(problem, Refused):
            row = {"task": problem.problem.name, "reason": problem.reason, "nearest_m": problem.nearest_m}
            found["refused"].append(row)
            continue
        number = len(found["tasks"])
        found["tasks"].append(known[number] if number < len(known) else _task(problem, limit_s))
        typer.echo(found["tasks"][-1])
        keep()
    while len(found["runs"]) < rounds:
        found["runs"].append(_round(tree, len(found["runs"])))
        keep()
    keep()
    typer.echo(f"{out / 'bodies.md'}")


def _task(problem: Problem, limit_s: float) -> dict[str, Any]:
    """Measure a task in a process of its own."""
    done = measure("tests.benchmarks.obstacles:measure_task", (problem.config,), limit_s)
    row = {"task": problem.name, **done.figures}
    return row if done.ended == FINISHED else {**row, "outcome": done.ended}


def _round(tree: Path | None, number: int) -> dict[str, Any]:
    """Run the reference machine without bodies, before there were any, and with bodies, one after the other."""
    typer.echo(f"round {number + 1}")
    before = {} if tree is None else {"before": (tree.resolve(), _WITHOUT)}
    cases = {**before, "without": (ROOT, _WITHOUT), "with": (ROOT, _WITH)}
    tables = {case: _table_seconds(*where) for case, where in cases.items()}
    return {
        case: {**measure_runs({case: folder}, [name], 1)[case]["runs"][name], "table_cpu_s": tables[case]}
        for case, (folder, name) in cases.items()
    }


def _table_seconds(tree: Path, name: str) -> float:
    """Measure the processor time of a checkout's region table: what else the machine does plays no role in it."""
    command = [sys.executable, "-c", _TABLE, str(tree / "configs" / f"{name}.yaml")]
    done = subprocess.run(
        command, cwd=tree, env={**os.environ, "PYTHONPATH": str(tree)}, check=True, capture_output=True
    )
    return float(done.stdout)


def page(found: dict[str, Any]) -> str:
    """Write everything as a page."""
    host = found["host"]
    sections = [
        "# Benchmark of bodies",
        "Written by `make bench-bodies`; every number is in `bodies.json`. "
        f"On {host['cpu']}, {host['cores']} cores, {host['date']}, load {host['load_before']:.1f} before the start.",
    ]
    if found.get("tasks"):
        sections += ["## Random obstacles", *_tasks(found)]
    if found.get("runs"):
        sections += ["## What bodies cost", *_costs(found["runs"])]
    return "\n\n".join(sections) + "\n"


def _tasks(found: dict[str, Any]) -> list[str]:
    tasks, refused = found["tasks"], found["refused"]
    ended = ", ".join(f"{count} {outcome}" for outcome, count in Counter(one["outcome"] for one in tasks).most_common())
    rows = [(str(number), one["task"], *_ending(one)) for number, one in enumerate(tasks, 1)]
    return [
        "The machine of `agder-bodies.yaml` on the grid of `quick.yaml`, among boxes, bars and stones drawn at random "
        "where it moves; every other task is the reference task, the others go from one random pose and mode to "
        f"another. Of {len(tasks)} tasks: {ended}.",
        _coal_words(found),
        table(
            ("", "task; obstacles", "seconds", "outcome", "route", "boxes", "proven mm", "coal mm", "asked of coal"),
            rows,
        ),
        *_reasons(tasks),
        f"On the way {len(refused)} more were drawn whose start or goal is refused for a pair that is too near"
        + (", which coal finds, too:" if all(one["nearest_m"] is not None for one in refused) else ":"),
        table(("refused", "nearest pair by coal, mm"), [(one["reason"], _mm(one["nearest_m"])) for one in refused]),
    ]


def _ending(one: dict[str, Any]) -> tuple[str, ...]:
    outcome = one["outcome"]
    if one.get("refused_claims"):
        outcome += "; not verified again: " + ", ".join(one["refused_claims"])
    if one.get("below"):
        outcome += "; nearer than proven by coal: " + ", ".join(one["below"])
    modes = " ".join(mode for mode, _ in groupby(one.get("modes", "").split()))
    route = f"{one['objective']:.2f}, {modes}" if "objective" in one else "-"
    figures = (str(one.get("boxes", "-")), _mm(one.get("proven_m")), _mm(one.get("nearest_m")))
    return (_seconds(one.get("seconds")), outcome, route, *figures, f"{one['asked']:,}" if "asked" in one else "-")


def _coal_words(found: dict[str, Any]) -> str:
    if not found["coal"]:
        return "Skipped: coal is not installed, so that no other library looked for collisions."
    certified = [one for one in found["tasks"] if "below" in one]
    pairs = sum(one["pairs"] for one in certified)
    below, refused = (sum(len(one[key]) for one in certified) for key in ("below", "refused_claims"))
    return (
        f"Every certificate was verified again by other arithmetic ({refused} claims refused), and another library, "
        f"coal, looked for collisions at {found['samples']:,} samples of each certified path: of {pairs:,} pairs of "
        f"bodies {below} came nearer than is proven. Where two known distances and the movement between them leave no "
        "room for that, samples were not asked for. *Proven* is the least distance of all pairs in the certificate, "
        "*coal* the least that it found."
    )


def _reasons(tasks: Sequence[dict[str, Any]]) -> list[str]:
    """State why there is no path, and what comes of leaving out obstacles."""
    lines = []
    for number, one in enumerate(tasks, 1):
        if "reason" in one:
            lines.append(f"- Task {number}: {one['reason']}.")
            lines += [f"  - {sentence}" for sentence in one.get("opens", [])]
    return ["Why there is none:", "\n".join(lines)] if lines else []


def _costs(rounds: Sequence[dict[str, Any]]) -> list[str]:
    """Compare runs: medians, and medians of the ratios within a round, of which the runs follow one another."""
    names = {"before": "agder, before there were bodies", "without": "agder", "with": "agder-bodies"}
    rows = [
        (
            label,
            *(f"{median(one[name][key] for one in rounds):.1f}" for key in ("wall_s", "cpu_s", "table_cpu_s")),
            *(f"{median(one[name]['stages'][stage] for one in rounds):.1f}" for stage in _STAGES),
        )
        for name, label in names.items()
        if name in rounds[0]
    ]
    ratios = [
        ("region table, with bodies to without", _ratios(rounds, "with", "without", "table_cpu_s"), _ASKED["regions"]),
        ("whole run, with bodies to without", _ratios(rounds, "with", "without", "cpu_s"), _ASKED["run"]),
        ("the same by the clock", _ratios(rounds, "with", "without", "wall_s"), _ASKED["run"]),
    ]
    if "before" in rounds[0]:
        ratios += [
            (f"{words}, without bodies to before", _ratios(rounds, "without", "before", key), _ASKED["before"])
            for words, key in (("region table", "table_cpu_s"), ("whole run", "cpu_s"))
        ]
    return [
        f"Whole runs into empty folders, medians of {len(rounds)} rounds in turns; processor seconds are those of all "
        "processes. Of the stages seconds by the clock.",
        table(("run", "seconds", "processor s", "of the region table", *_STAGES), rows),
        "Medians of the ratios within each round, of processor seconds unless said otherwise:",
        table(
            ("", "ratio", "least", "largest", "asked for at most"),
            [(one, *_spread(r), f"{a:g}") for one, r, a in ratios],
        ),
    ]


_STAGES = ("regions", "route", "refine", "certify", "retime", "figures")


def _ratios(rounds: Sequence[dict[str, Any]], over: str, under: str, key: str) -> list[float]:
    return [one[over][key] / one[under][key] for one in rounds]


def _spread(ratios: Sequence[float]) -> tuple[str, ...]:
    return tuple(f"{value:.2f}" for value in (median(ratios), min(ratios), max(ratios)))


def _mm(value_m: float | None) -> str:
    return "-" if value_m is None else f"{1e3 * value_m:.2f}"


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module.
    main()
