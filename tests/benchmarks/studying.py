"""Studies: throughput of one and two workers, what a run costs beside its own work, and a million runs on paper.

`python -m tests.benchmarks.studying` writes `results/benchmarks/study.md` and `study.json`: ten minutes.
"""

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

from pipeline.progress import Monitor
from pipeline.study.cases import build_cases
from pipeline.study.config import parse_study
from pipeline.study.engine import Engine, Fixed, Setting
from pipeline.study.pool import local_pool
from pipeline.study.program import program_version
from pipeline.study.report import render_study
from pipeline.study.store import STORE, Store
from pipeline.study.table import build_table
from tests.benchmarks.host import describe_host
from tests.benchmarks.study_kills import ROOT, environment

RESULTS = ROOT / "results" / "benchmarks"
_MANY, _WORKERS, _RUN_S = 1_000_000, 1_000, 20.0
"""The study on paper: runs, workers, and seconds that a run of `quick.yaml` takes."""
_REPEATS = 3
"""Studies with one and with two workers, in turn; the fastest of each counts, as others use the machine, too."""
_SETTLED = 200
"""Short runs after which the memory of client and scheduler is taken as settled."""


@dataclass(frozen=True)
class Led:
    """A study that was led, measured from the moment when its workers were ready."""

    runs: int
    seconds: float
    own_s: float
    memory_mb: dict[int, float]
    client_s: float

    @property
    def per_second(self) -> float:
        """Runs per second."""
        return self.runs / self.seconds


def lead(folder: Path, workers: int, study: dict[str, Any]) -> Led:
    """Lead a study on workers of this machine; their start is not counted, the first import of libraries is."""
    parsed = parse_study(study)
    cases = build_cases(parsed, ROOT / "configs" / "x.yaml", program_version())
    folder.mkdir()
    process, memory = psutil.Process(), dict[int, float]()
    with local_pool(workers, 1, 4.2) as pool, Store(folder) as store:

        def progress(message: str, _fraction: float | None = None) -> None:
            done = int(message.split(" ")[0].replace(",", "")) if message[:1].isdigit() else 0
            if done and done % _SETTLED == 0:
                memory[done] = process.memory_info().rss / 1e6

        setting = Setting(folder, parsed.to, cases.program, parsed.run)
        warm = Engine(setting, lambda: pool, store, None, Monitor())
        warm.lead(Fixed(iter(list(cases)[:workers])))
        known = workers
        began, used = time.perf_counter(), time.process_time()
        Engine(setting, lambda: pool, store, len(cases), Monitor(progress)).lead(Fixed(iter(cases)))
        seconds, client_s = time.perf_counter() - began, time.process_time() - used
        own_s = sum(row.seconds for row in store.rows()) * (len(cases) - known) / len(cases)
    return Led(len(cases) - known, seconds, own_s, memory, client_s)


def routes(base: str, runs: int) -> dict[str, Any]:
    """Plan routes that differ in what regions and moves are admitted."""
    varied = {"key": "route.kappa_max", "min": 60, "max": 100, "count": runs}
    return {"base": base, "to": "route", "parameters": [varied]}


def refusals(runs: int) -> dict[str, Any]:
    """Make runs as short as there are: the start is tilted more than the limit allows."""
    tilts = {"key": "task.tilt_max_deg", "min": 1.0, "max": 5.0, "count": runs}
    tilted = {"key": "task.start.rx_deg", "values": [6.0]}
    return {"base": "tiny.yaml", "to": "route", "parameters": [tilts, tilted], "run": {"keep": "none"}}


def loop(folder: Path, base: str, runs: int) -> float:
    """Run the command once per run, one after the other; return the seconds per run."""
    began = time.perf_counter()
    for number in range(runs):
        out = folder / f"{number}"
        command = [sys.executable, "-m", "pipeline", "run", str(ROOT / "configs" / base), "--out", str(out)]
        pinned = {**environment(), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "GANTRY_TAU_THREADS": "1"}
        subprocess.run([*command, "--to", "route"], env=pinned, check=True, capture_output=True)
    return (time.perf_counter() - began) / runs


def short_runs(folder: Path, runs: int) -> dict[str, Any]:
    """Lead many short runs, and measure what grows with their number."""
    study = refusals(runs)
    led = lead(folder, 2, study)
    parsed = parse_study(study)
    cases = build_cases(parsed, ROOT / "configs" / "x.yaml", program_version())
    began = time.perf_counter()
    count = sum(1 for _ in cases)
    case_s = (time.perf_counter() - began) / count
    with Store(folder) as store:
        began = time.perf_counter()
        table = build_table(cases, store)
        table_s = (time.perf_counter() - began) / count
        began = time.perf_counter()
        render_study(parsed, table, count, lambda run: run)
        report_s = time.perf_counter() - began
    return {
        "runs": led.runs,
        "per_second": led.per_second,
        "memory_mb": led.memory_mb,
        "client_ms": 1e3 * led.client_s / led.runs,
        "case_us": 1e6 * case_s,
        "table_us": 1e6 * table_s,
        "report_s": report_s,
        "store_bytes": (folder / STORE).stat().st_size / count,
    }


def folder_bytes(folder: Path, pattern: str) -> float:
    """Measure the mean size of the run folders of a study, or of some files in them."""
    runs = [entry for entry in (folder / "runs").iterdir() if not entry.name.startswith(".")]
    return sum(file.stat().st_size for run in runs for file in run.rglob(pattern) if file.is_file()) / len(runs)


def measure(runs: int, quick_runs: int, short: int) -> dict[str, Any]:
    """Measure everything."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found: dict[str, Any] = {"host": describe_host(), "throughput": {}}
        for base, count in (("tiny.yaml", runs), ("quick.yaml", quick_runs)):
            led = {workers: lead(folder / f"{base}{workers}", workers, routes(base, count)) for workers in (1, 2)}
            for repeat in range(1, _REPEATS):
                for workers, best in led.items():
                    again = lead(folder / f"{base}{workers}-{repeat}", workers, routes(base, count))
                    led[workers] = max(best, again, key=lambda one: one.per_second)
            found["throughput"][base] = {
                "runs": count,
                "per_second": {workers: one.per_second for workers, one in led.items()},
                "busy": {workers: one.own_s / one.seconds for workers, one in led.items()},
                "ratio": led[2].per_second / led[1].per_second,
                "seconds_per_run": led[1].seconds / led[1].runs,
                "overhead_per_run_s": (led[1].seconds - led[1].own_s) / led[1].runs,
                "loop_seconds_per_run": loop(folder / f"loop{base}", base, 5),
                "folder_bytes": folder_bytes(folder / f"{base}1", "*"),
                "row_bytes": folder_bytes(folder / f"{base}1", "row-*"),
            }
        found["short"] = short_runs(folder / "short", short)
    return found


def report(found: dict[str, Any]) -> str:
    """Write what was measured as Markdown."""
    host, short = found["host"], found["short"]
    lines = [
        "# Studies",
        "",
        f"Measured {host['date'][:10]} on {host['cpu']}, {host['cores']} cores, load {host['load_before']:.1f} before, "
        "by `make bench-study`.",
        "",
        "Routes on two grids, each with 60 to 100 for the largest kappa admitted. A run's own work is what its process "
        "says; all else between two runs is overhead. The loop is `gantry-tau run --to route`, once per run, with one "
        "thread, as a worker has. Of three studies each, in turn, the fastest one counts: others use the machine, too.",
        "",
        "Busy is how many of two workers were at a run at a time, on average: the ratio with two free cores.",
        "",
        "| grid | runs | one worker, runs/s | two, runs/s | ratio | busy | s per run | overhead, s | loop, s per run |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for base, one in found["throughput"].items():
        rates = {int(workers): rate for workers, rate in one["per_second"].items()}
        busy = {int(workers): count for workers, count in one["busy"].items()}
        lines.append(
            f"| `{base}` | {one['runs']} | {rates[1]:.2f} | {rates[2]:.2f} | {one['ratio']:.2f} | {busy[2]:.2f} | "
            f"{one['seconds_per_run']:.3f} | {one['overhead_per_run_s']:.4f} | {one['loop_seconds_per_run']:.2f} |"
        )
    memory = {int(done): size for done, size in short["memory_mb"].items()}
    lines += [
        "",
        f"{short['runs']:,} runs of a few milliseconds on two workers: {short['per_second']:.0f} per second, with "
        f"{short['client_ms']:.1f} ms of processor time each for client and scheduler, which are one process here. "
        "Its memory: " + ", ".join(f"{size:.0f} MB after {done:,}" for done, size in memory.items()) + ".",
        "",
        *_on_paper(found),
    ]
    return "\n".join(lines) + "\n"


def _on_paper(found: dict[str, Any]) -> list[str]:
    """Scale what was measured to a million runs on a thousand workers."""
    short, quick = found["short"], found["throughput"]["quick.yaml"]
    rate = 1e3 / short["client_ms"]
    needed = _WORKERS / _RUN_S
    hours = _MANY * _RUN_S / _WORKERS / 3600.0
    store_gb = _MANY * (short["store_bytes"] + quick["row_bytes"]) / 1e9
    disk_tb = _MANY * quick["folder_bytes"] / 1e12
    shortest = f"runs of {_WORKERS / rate:.1f} s or more"
    rows = (
        ("runs per second", f"{needed:.0f} ({_RUN_S:.0f} s each)", f"{rate:.0f}", shortest),
        ("cases made", "once per start", f"{short['case_us']:.0f} µs", f"{_MANY * short['case_us'] / 6e7:.0f} min"),
        ("rows on disk", "one per run", f"{quick['row_bytes']:.0f} B", f"{store_gb:.0f} GB"),
        ("table", "once per start", f"{short['table_us']:.0f} µs", f"{_MANY * short['table_us'] / 6e7:.0f} min"),
        ("run folders", "one per run", f"{quick['folder_bytes'] / 1e6:.1f} MB", f"{disk_tb:.1f} TB"),
    )
    return [
        "## A million runs on a thousand workers, on paper",
        "",
        f"{_MANY:,} runs of {_RUN_S:.0f} s on {_WORKERS:,} workers take {hours:.1f} h.",
        "",
        "| what | needed | measured | for a million |",
        "|---|---|---|---|",
        *(f"| {' | '.join(row)} |" for row in rows),
        "",
        "- **Run folders break first**: they fill the disk, and millions of files are slow anywhere. "
        "`run.keep: none` (or `failed`) keeps the row of a run, and nothing else of its folder.",
        "- **A scheduler that is given all tasks at a time** would hold a million of them, some gigabytes. The client "
        "keeps a tenth more with the workers than they can run, so that the scheduler's memory goes with workers, not "
        "with runs; its histories are cut to a hundred entries.",
        "- **Names of tasks** were all different at first: Dask keeps statistics of every prefix for good, 6 kB "
        "per run, which would have been 6 GB. They have one prefix now, and memory stays flat.",
        "- **Client and scheduler** take rows one by one. With runs shorter than the table says, workers would wait "
        "for them. What was not measured is a scheduler with a thousand connections.",
        "- **A configuration per case** would be tens of kilobytes each in memory: copies share what does not vary, "
        "and the table drops them. Name the `figures` you need: without, the table has a hundred per run.",
        "- **A start again** makes all cases once more to see which are done. It costs minutes, and no run.",
    ]


def main() -> None:
    """Measure, and write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--quick-runs", type=int, default=40)
    parser.add_argument("--short", type=int, default=2_000)
    parser.add_argument("--out", type=Path, default=RESULTS)
    asked = parser.parse_args()
    with contextlib.suppress(PermissionError):
        os.nice(-12)
    found = measure(asked.runs, asked.quick_runs, asked.short)
    (asked.out / "study.json").write_text(json.dumps(found, indent=2) + "\n")
    (asked.out / "study.md").write_text(report(found))
    print(report(found))  # noqa: T201


if __name__ == "__main__":
    main()
