"""What is proven of motions against samples of them: random tasks and packaged ones; `make bench-retime`."""

import itertools
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Annotated, Any

import numpy as np
import typer

from pipeline.artifacts import json_bytes, write_whole
from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import PipelineError
from pipeline.machine import build_machine
from pipeline.refine import refine_path
from pipeline.retime import (
    Trajectory,
    interpolations,
    measure_usage,
    require_proven,
    retime_path,
    sample_trajectory,
    way_back,
    whole_periods,
)
from pipeline.route import build_regions, plan_route
from tests.benchmarks.host import describe_host
from tests.benchmarks.problems import CONFIGS, Problem
from tests.benchmarks.variety import random_tasks

ROOT = FilePath(__file__).parents[2]
PACKAGED = ("quick", "fast", "agder")
_KINEMATIC, _LOADS = ("velocity", "acceleration", "jerk"), ("force", "link_force")
_LEAST = 1e-3
"""Part of a limit below which bounds need not be near samples."""


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    tasks: Annotated[int, typer.Option(help="random tasks that have a path")] = 20,
    out: Annotated[FilePath, typer.Option(help="folder for law.json and law.md")] = ROOT / "results" / "benchmarks",
) -> None:
    """Prove the motions of random tasks and of the packaged ones, there and back."""
    found = {"host": describe_host(), "motions": []}
    known = [Problem(name, load_config(CONFIGS / f"{name}.yaml")) for name in PACKAGED]
    solved = 0
    for problem in itertools.chain(known, random_tasks(4 * tasks)):
        if solved == len(known) + tasks:
            break
        rows = list(measure_proof(problem))
        solved += bool(rows)
        found["motions"] += rows
        typer.echo(f"{problem.name}: {len(rows)} motions")
        write_whole(out / "law.json", json_bytes(found))
        write_whole(out / "law.md", markdown(found).encode())
    typer.echo(f"{out / 'law.md'}")


def measure_proof(problem: Problem) -> Iterator[dict[str, Any]]:
    """Plan and time a task, and compare what is proven of its motion and of its way back with dense samples."""
    config = problem.config
    try:
        there = _planned(config)
        back = way_back(config, there)
    except PipelineError:
        return
    for name, motion in (("there", there), ("back", back)):
        yield {"task": problem.name, "way": name, **compare(motion, config)}


def _planned(config: Config) -> Trajectory:
    machine = build_machine(config.machine)
    route = plan_route(config, machine, build_regions(config, machine))
    return retime_path(config, refine_path(config, machine, route).path)


def compare(motion: Trajectory, config: Config) -> dict[str, Any]:
    """Compare the proven parts of all limits with the largest of a hundred instants per period."""
    jerk, period_s = config.retime.jerk, config.retime.period_s
    proof = require_proven(motion, jerk=jerk, loads=True)
    sampled = measure_usage(motion, period_s / 10.0).fractions
    fitted = whole_periods(motion, period_s)
    rows = interpolations(fitted, sample_trajectory(fitted, period_s), jerk=jerk)
    return {
        "duration_s": motion.duration_s,
        "proven": {name: float(part.max()) for name, part in proof.fractions.items()},
        "above": {name: _above(part, sampled[name]) for name, part in proof.fractions.items()},
        "intervals": proof.intervals,
        "rows": {one.method: one.largest for one in rows},
    }


def _above(proven: np.ndarray, sampled: np.ndarray) -> float:
    """Give by how much bounds are above samples at most, relatively, of those that matter."""
    counts = sampled > _LEAST
    return float((proven[counts] / sampled[counts] - 1.0).max(initial=0.0))


def markdown(found: dict[str, Any]) -> str:
    """Write the page."""
    motions = found["motions"]
    kinematic = [max(row["proven"].get(name, 0.0) for name in _KINEMATIC) for row in motions]
    above = [max(row["above"].get(name, 0.0) for name in _KINEMATIC) for row in motions]
    loads = [max(row["above"].get(name, 0.0) for name in _LOADS) for row in motions]
    lines = [
        "# Benchmark of the proof of motions",
        "",
        "Written by `make bench-retime`; all numbers are in `law.json`. Random tasks are of the reference machine, on "
        "the grids of `configs/quick.yaml`. *Above* is how far a proven use of a limit is above the largest of 100 "
        "instants per period, relatively, for the actuator or link where it is most. The last column: the largest use "
        "of a limit that a controller makes of rows 10 ms apart.",
        "",
        *(f"- {key}: {value}" for key, value in found["host"].items()),
        "",
        f"{len(motions)} motions: proven use of velocity, acceleration and jerk at most {max(kinematic):.6f}, at most "
        f"{max(above):.3%} above samples; forces at most {max(loads):.1%} above.",
        "",
        "| task | way | duration s | velocity | acceleration | jerk | above | force | link force | above | intervals "
        "| rows: linear, cubic, quintic |",
        "|" + " --- |" * 12,
    ]
    for row, beyond, loaded in zip(motions, above, loads, strict=True):
        proven = [f"{row['proven'][name]:.5f}" if name in row["proven"] else "" for name in (*_KINEMATIC, *_LOADS)]
        cells = [
            row["task"],
            row["way"],
            f"{row['duration_s']:.2f}",
            *proven[:3],
            f"{beyond:.3%}",
            *proven[3:],
            f"{loaded:.1%}",
            f"{row['intervals']:,}",
            ", ".join(f"{part:.3f}" for part in row["rows"].values()),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
