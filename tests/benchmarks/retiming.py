"""Stage three measured: grids, bound, limited jerk, and what an engineer would use instead; `make bench-retime`."""

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Annotated, Any

import numpy as np
import typer

from pipeline.artifacts import json_bytes, write_whole
from pipeline.config.file import load_config
from pipeline.refine.result import Path
from pipeline.retime import measure_usage, retime_path
from pipeline.retime.constraints import limit_rows
from pipeline.retime.duration_bound import duration_bound
from pipeline.retime.fastest import plan_rows
from pipeline.retime.jerk.solve import limit_jerk
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.run import RunOptions, run_pipeline
from pipeline.run.reading import open_results
from pipeline.stage import Stage
from tests.benchmarks.alternatives import ALTERNATIVES
from tests.benchmarks.host import describe_host

ROOT = FilePath(__file__).parents[2]
GRIDS = (100, 200, 500, 1_000, 2_000, 4_000)
PIECES = (100, 150, 250, 400)
_REPEATS = 5


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    config: Annotated[FilePath, typer.Option(help="the task whose path is timed")] = ROOT / "configs" / "agder.yaml",
    run: Annotated[FilePath, typer.Option(help="its run folder")] = ROOT / "results" / "agder",
    out: Annotated[FilePath, typer.Option(help="folder for retime.json and retime.md")] = ROOT
    / "results"
    / "benchmarks",
) -> None:
    """Measure stage three on the refined path of a task."""
    run_pipeline(load_config(config), run, RunOptions(last=Stage.REFINE))
    results = open_results(run, Stage.REFINE)
    found = study(results.refinement.path, results.route.q_m)
    found["host"] = describe_host()
    began = time.perf_counter()
    whole = retime_path(results.config, results.refinement.path)
    found["stage"] = {
        "seconds": time.perf_counter() - began,
        "duration_s": whole.duration_s,
        "usage": measure_usage(whole, results.config.retime.period_s).largest,
    }
    write_whole(out / "retime.json", json_bytes(found))
    write_whole(out / "retime.md", markdown(found).encode())
    typer.echo(f"{out / 'retime.md'}")


def study(path: Path, waypoints: np.ndarray, grids: tuple[int, ...] = GRIDS, pieces: tuple[int, ...] = PIECES) -> Any:
    """Measure everything on one path; `waypoints` (n, 5) are the steps of its route."""
    table = tabulate_dynamics(path, grid(4_001))
    finest = duration_bound(table, grid(2 * grids[-1]))
    fastest = plan_rows(path, grid(grids[-1]), limit_rows(table.at(grid(grids[-1]))))
    return {
        "bound_s": finest,
        "grids": [_measure_grid(path, points, finest) for points in grids],
        "bounds": [_measure_bound(table, points, fastest.duration_s) for points in grids],
        "jerk": [_measure_jerk(table, fastest, count) for count in pieces],
        "alternatives": [{"name": name, **_measure_alternative(way, path, waypoints)} for name, way in ALTERNATIVES],
    }


def _measure_grid(path: Path, points: int, bound_s: float) -> dict[str, Any]:
    s = grid(points)
    rows_s, rows = _median(lambda: limit_rows(evaluate_dynamics(path, s)))
    plan_s, planned = _median(lambda: plan_rows(path, s, rows))
    return {
        "points": points,
        "rows_s": rows_s,
        "plan_s": plan_s,
        "duration_s": planned.duration_s,
        "gap": 1.0 - bound_s / planned.duration_s,
        "usage": measure_usage(planned).largest,
    }


def _measure_bound(table: Any, points: int, fastest_s: float) -> dict[str, Any]:
    seconds, bound = _median(lambda: duration_bound(table, grid(points)))
    return {"points": points, "seconds": seconds, "bound_s": bound, "gap": 1.0 - bound / fastest_s}


def _measure_jerk(table: Any, fastest: Any, pieces: int) -> dict[str, Any]:
    began = time.perf_counter()
    found = limit_jerk(table, fastest, pieces)
    seconds = time.perf_counter() - began
    usage = measure_usage(found.trajectory, 0.001)
    return {
        "pieces": pieces,
        "final_pieces": found.pieces,
        "seconds": seconds,
        "rounds": found.rounds,
        "iterations": found.iterations,
        "duration_s": found.trajectory.motion_s,
        "cost": found.trajectory.motion_s / fastest.duration_s - 1.0,
        "usage": usage.largest,
    }


def _measure_alternative(way: Callable[..., float], path: Path, waypoints: np.ndarray) -> dict[str, Any]:
    try:
        return {"duration_s": way(replace(path, machine=path.machine), waypoints)}
    except ModuleNotFoundError as error:
        return {"duration_s": None, "why": f"{error.name} is not installed"}


def _median(act: Callable[[], Any]) -> tuple[float, Any]:
    """Act five times; the median of the seconds, and the last result."""
    seconds, result = [], None
    for _ in range(_REPEATS):
        began = time.perf_counter()
        result = act()
        seconds.append(time.perf_counter() - began)
    return statistics.median(seconds), result


def markdown(found: dict[str, Any]) -> str:
    """Write the page."""
    stage, host = found["stage"], found["host"]
    lines = [
        "# Benchmark of stage three",
        "",
        "Written by `make bench-retime`; every number is in `retime.json`. Seconds are wall-clock, medians of five "
        "but for limited jerk. The path is the refined one of the reference machine, limits are its configuration's.",
        "",
        *(f"- {key}: {value}" for key, value in host.items()),
        "",
        f"The whole stage: {stage['seconds']:.2f} s, a motion of {stage['duration_s']:.3f} s, largest use of a limit "
        f"{stage['usage']:.4f}.",
        "",
        "## Without jerk limits: the grid",
        "",
        f"The bound of the finest grid is {found['bound_s']:.4f} s.",
        "",
        *_table(
            (
                "points",
                "limits evaluated s",
                "TOPP-RA s",
                "duration s",
                "above the bound",
                "largest use between points",
            ),
            [
                (
                    f"{row['points']:,}",
                    f"{row['rows_s']:.3f}",
                    f"{row['plan_s']:.3f}",
                    f"{row['duration_s']:.4f}",
                    f"{row['gap']:.2%}",
                    f"{row['usage']:.4f}",
                )
                for row in found["grids"]
            ],
        ),
        "",
        "## The lower bound",
        "",
        *_table(
            ("points", "seconds", "bound s", "below TOPP-RA on the finest grid"),
            [
                (f"{row['points']:,}", f"{row['seconds']:.3f}", f"{row['bound_s']:.4f}", f"{row['gap']:.2%}")
                for row in found["bounds"]
            ],
        ),
        "",
        "## Limited jerk",
        "",
        *_table(
            ("pieces", "after halving", "seconds", "rounds", "iterations", "duration s", "cost of jerk", "largest use"),
            [
                (
                    f"{row['pieces']}",
                    f"{row['final_pieces']}",
                    f"{row['seconds']:.2f}",
                    f"{row['rounds']}",
                    f"{row['iterations']}",
                    f"{row['duration_s']:.4f}",
                    f"{row['cost']:+.2%}",
                    f"{row['usage']:.4f}",
                )
                for row in found["jerk"]
            ],
        ),
        "",
        "## What one would use instead",
        "",
        "All keep velocity, acceleration and jerk limits of the actuators, unless their name says otherwise; those "
        "along the path keep to it, and run on a parameter along which the velocity limits are about even.",
        "",
        *_table(
            ("method", "duration s", "longer than ours"),
            [
                (
                    row["name"],
                    row.get("why") or f"{row['duration_s']:.2f}",
                    "" if row["duration_s"] is None else f"{row['duration_s'] / stage['duration_s'] - 1.0:+.0%}",
                )
                for row in found["alternatives"]
            ],
        ),
        "",
    ]
    return "\n".join(lines)


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    cells = [head, ("---",) * len(head), *rows]
    return [f"| {' | '.join(row)} |" for row in cells]


if __name__ == "__main__":
    main()
