"""Whole runs from the command line: seconds of every stage, processor time and memory, one file per date.

`python -m tests.benchmarks.whole_runs` measures, adds the file of today to `results/benchmarks/history`, and draws and
tabulates all of them. With `--tree`, the same for another checkout, in turns with this one: before and after.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import typer

from pipeline.artifacts import json_bytes, write_whole
from tests.benchmarks.history import read_history, runs_page, runs_picture
from tests.benchmarks.host import describe_host

ROOT = Path(__file__).parents[2]
_OUT = ROOT / "results" / "benchmarks"
_CONFIGS = ("agder", "quick", "fast")


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for history/DATE.json, runs.md and its picture")] = _OUT,
    runs: Annotated[int, typer.Option(min=1, help="runs of each configuration, of which medians are taken")] = 5,
    only: Annotated[list[str] | None, typer.Option(help="configurations; all if there is none")] = None,
    tree: Annotated[Path | None, typer.Option(help="another checkout, measured in turns with this one")] = None,
) -> None:
    """Measure whole runs, and how long the program takes to start."""
    names = tuple(only or _CONFIGS)
    trees = {"after": ROOT} if tree is None else {"before": tree.resolve(), "after": ROOT}
    host = describe_host()
    found = measure(trees, names, runs)
    results = {"host": host, "repeats": runs, **found["after"]}
    if tree is not None:
        results["before"] = found["before"]
    write_whole(out / "history" / f"{str(host['date'])[:10]}.json", json_bytes(results))
    history = read_history(out / "history")
    write_whole(out / "history" / "runs.png", runs_picture(history))
    write_whole(out / "runs.md", runs_page(history).encode())
    typer.echo(f"{out / 'runs.md'}")


def measure(trees: Mapping[str, Path], names: Sequence[str], repeats: int) -> dict[str, dict[str, Any]]:
    """Measure checkouts by their names, in turns, so that what else the machine does disturbs all of them alike."""
    rounds: dict[str, dict[str, list[dict[str, Any]]]] = {tree: {name: [] for name in names} for tree in trees}
    starts: dict[str, list[dict[str, float]]] = {tree: [] for tree in trees}
    for number in range(repeats):
        for tree, folder in trees.items():
            starts[tree].append(_start(folder))
            for name in names:
                typer.echo(f"{tree}, run {number + 1} of {name}")
                rounds[tree][name].append(_run(folder, name))
    return {
        tree: {"start": _medians(starts[tree]), "runs": {name: _medians(rounds[tree][name]) for name in names}}
        for tree in trees
    }


def _run(tree: Path, name: str) -> dict[str, Any]:
    """Run a configuration into an empty folder: nothing is known from earlier runs."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / name
        figures = _timed(tree, "-m", "pipeline", "run", f"configs/{name}.yaml", "--out", str(out))
        state = json.loads((out / "state.json").read_text(encoding="utf-8"))
    stages = {stage: record["seconds"] for stage, record in state["stages"].items()}
    return {**figures, "stages": stages}


def _start(tree: Path) -> dict[str, float]:
    return {
        "import_s": _timed(tree, "-c", "import pipeline")["wall_s"],
        "help_s": _timed(tree, "-m", "pipeline", "--help")["wall_s"],
    }


def _timed(tree: Path, *arguments: str) -> dict[str, float]:
    """Run Python in a checkout; seconds, processor time of all its processes, and the memory of the largest."""
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    # Compiled modules are kept, as they are for everyone who runs the program twice.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, *arguments], cwd=tree, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise typer.BadParameter(f"{' '.join(arguments)} failed in {tree}", param_hint="--only")
    return {
        "wall_s": time.perf_counter() - began,
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "peak_mb": usage.ru_maxrss * 1024 / 1e6,
    }


def _medians(rounds: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    first = rounds[0]
    return {
        key: _medians([one[key] for one in rounds]) if isinstance(value, dict) else median(one[key] for one in rounds)
        for key, value in first.items()
    }


if __name__ == "__main__":
    typer.run(benchmark)
