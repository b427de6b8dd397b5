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
_NAMES = {"before": "agder before there were bodies", "without": "agder", "with": "agder-bodies"}
_STAGES = ("regions", "route", "refine", "certify", "retime", "figures")


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
    found |= {key: before.get(key, [])[:rounds] for key in ("tables", "runs")}

    def keep() -> None:
        write_whole(file, json_bytes(found))
        write_whole(out / "bodies.md", page(found).encode())

    for problem in obstacle_tasks(tasks):
        if isinstance(problem, Refused):
            row = {"task": problem.problem.name, "reason": problem.reason, "nearest_m": problem.nearest_m}
            found["refused"].append(row)
            continue
        number = len(found["tasks"])
        is_known = number < len(known) and "seconds" in known[number]
        found["tasks"].append(known[number] if is_known else _task(problem, limit_s))
        typer.echo(found["tasks"][-1])
        keep()
    cases = _cases(tree)
    for key, measured in (("tables", _table_seconds), ("runs", _run)):
        while len(found[key]) < rounds:
            typer.echo(f"{key}, round {len(found[key]) + 1}")
            found[key].append({case: measured(*where) for case, where in cases.items()})
            keep()
    keep()
    typer.echo(f"{out / 'bodies.md'}")


def _task(problem: Problem, limit_s: float) -> dict[str, Any]:
    """Measure a task in a process of its own."""
    done = measure("tests.benchmarks.obstacles:measure_task", (problem.config,), limit_s)
    row = {"task": problem.name, **done.figures}
    return row if done.ended == FINISHED else {**row, "outcome": done.ended}


def _cases(tree: Path | None) -> dict[str, tuple[Path, str]]:
    """List what is compared, one after the other in every round: checkouts and their configurations."""
    before = {} if tree is None else {"before": (tree.resolve(), _WITHOUT)}
    return {**before, "without": (ROOT, _WITHOUT), "with": (ROOT, _WITH)}


def _run(tree: Path, name: str) -> dict[str, Any]:
    """Measure a whole run."""
    return dict(measure_runs({name: tree}, [name], 1)[name]["runs"][name])


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
    if found.get("tables"):
        sections += ["## What bodies cost", *_costs(found["tables"], found["runs"])]
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
        table(
            ("refused", "nearest pair by coal, mm"),
            [(one["reason"].split(";")[0], _mm(one["nearest_m"])) for one in refused],
        ),
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


def _costs(tables: Sequence[dict[str, float]], runs: Sequence[dict[str, Any]]) -> list[str]:
    """Compare region tables and whole runs; those of a round follow one another."""
    parts = [
        _ratio("region table, with bodies to without", tables, "with", "without", 4.0),
        _ratio("region table, without bodies to before there were any", tables, "without", "before", 1.05),
    ]
    cpu, wall = ([{case: one[case][key] for case in one} for one in runs] for key in ("cpu_s", "wall_s"))
    if runs:
        parts += [
            _ratio("whole run, with bodies to without", cpu, "with", "without", 2.5),
            _ratio("the same by the clock", wall, "with", "without", 2.5),
            _ratio(
                "whole run, without bodies to before, all else that is new included", cpu, "without", "before", 1.05
            ),
        ]
    found = [
        "Medians of the ratios of processor seconds within each round, in which agder before there were bodies, agder "
        "and agder-bodies are measured in turns:",
        table(("", "rounds", "ratio", "least", "largest", "asked for at most"), [part for part in parts if part]),
        "Processor seconds of region tables, medians: "
        + ", ".join(f"{_NAMES[case]} {median(one[case] for one in tables):.1f}" for case in tables[0])
        + ".",
    ]
    return [*found, *_runs_table(runs)] if runs else found


def _ratio(
    words: str, rounds: Sequence[dict[str, float]], over: str, under: str, asked: float
) -> tuple[str, ...] | None:
    """Tabulate ratios of what is measured; None if it is not."""
    if under not in rounds[0]:
        return None
    ratios = [one[over] / one[under] for one in rounds]
    shown = (f"{value:.2f}" for value in (median(ratios), min(ratios), max(ratios)))
    return (words, str(len(rounds)), *shown, f"{asked:g}")


def _runs_table(runs: Sequence[dict[str, Any]]) -> list[str]:
    rows = [
        (
            _NAMES[case],
            *(f"{median(one[case][key] for one in runs):.1f}" for key in ("wall_s", "cpu_s")),
            *(f"{median(one[case]['stages'][stage] for one in runs):.1f}" for stage in _STAGES),
        )
        for case in runs[0]
    ]
    words = (
        "Whole runs into empty folders, medians; processor seconds are of all processes, those of stages by the clock."
    )
    return [words, table(("run", "seconds", "processor s", *_STAGES), rows)]


def _mm(value_m: float | None) -> str:
    return "-" if value_m is None else f"{1e3 * value_m:.2f}"


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module.
    main()
