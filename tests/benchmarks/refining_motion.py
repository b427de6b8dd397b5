"""The motion of a whole run before and after the defaults that smooth it; the second part of `make bench-refine`.

On fixed tasks and random machines, into motion.json and motion.md.
"""

import copy
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import numpy as np
import typer

from pipeline.artifacts import json_bytes, write_whole
from pipeline.certify import certify_path
from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.errors import NoSolutionError
from pipeline.machine import build_machine
from pipeline.refine import measure_path, refine_path, sample_path
from pipeline.refine.check import find_violations
from pipeline.retime import measure_quality, retime_path
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes
from tests.benchmarks.host import describe_host
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.problems import CONFIGS, Problem
from tests.benchmarks.report import table
from tests.benchmarks.variety import CHECK_POINTS, random_machines

_OUT = Path(__file__).parents[2] / "results" / "benchmarks"
BEFORE = {"route": {"objective": "sum"}, "refine": {"smoothness": 0.0, "corridor_cells": 1.0}}
"""What the defaults were: the sum of kappa (5), cells widened by one, and no cost of the third derivative."""

_LEFT = {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "mode": "LLL"}
_RIGHT = {**_LEFT, "mode": "RRR"}
_TILT = {"rx_deg": 5.0, "rz_deg": -5.0}
_TASKS: tuple[tuple[str, dict[str, Any], dict[str, Any], dict[str, Any]], ...] = (
    ("all arms, in place", {}, {}, {}),
    ("all arms, back", {"mode": "RRR"}, {"mode": "LLL"}, {}),
    ("all arms, x 1.3 to 0.8", {"x_m": 1.3}, {"x_m": 0.8}, {}),
    ("all arms, x 1.5 to 1.0", {"x_m": 1.5}, {"x_m": 1.0}, {}),
    ("all arms, x 1.6 to 0.2", {"x_m": 1.6}, {"x_m": 0.2}, {}),
    ("all arms, diagonally", {"y_m": 0.5, "z_m": 0.8}, {"y_m": 0.2, "z_m": 1.0}, {}),
    ("all arms, back, other y and z", {"mode": "RRR", "y_m": 0.2, "z_m": 1.0}, {"mode": "LLL", "y_m": 0.5}, {}),
    ("all arms, tilted ends", _TILT, {"rx_deg": -5.0, "rz_deg": 5.0}, {}),
    ("all arms, up by 0.2", {"z_m": 0.8}, {"z_m": 1.0}, {}),
    ("all arms, tilt at most 20°", {}, {}, {"tilt_max_deg": 20.0}),
    ("all arms, rx locked", {}, {}, {"locked_axes": ["rx"]}),
    ("all arms, by a box", {}, {}, {"visit": [{"box": {"y_m": [0.4, 0.6], "z_m": [0.9, 1.1]}}]}),
    ("one arm", {}, {"mode": "RLL", "rx_deg": 0.0, "rz_deg": 5.0}, {}),
    ("plain X, 1.0 to 2.2", {"x_m": 1.0}, {"x_m": 2.2, "mode": "LLL"}, {}),
    ("plain X, all right", {"mode": "RRR", "x_m": 0.3}, {"x_m": 1.0}, {}),
    ("plain YZ", {"x_m": 1.2}, {"x_m": 1.2, "y_m": 0.6, "mode": "LLL"}, {}),
    ("plain tilt", {"x_m": 1.0, "rx_deg": -10.0}, {"x_m": 1.6, "rx_deg": 10.0, "mode": "LLL"}, {}),
    ("plain, all coordinates", {"x_m": 1.0, "y_m": 0.5}, {"x_m": 1.6, "y_m": 0.3, "z_m": 1.0, "mode": "LLL"}, {}),
)
"""Name, what start and goal change of the reference task's, and the rest of the task."""
_COMPARED = {
    "duration_s": "duration, s",
    "kappa_integral": "integral of kappa",
    "kappa_max": "largest kappa",
    "acceleration_sign_changes": "sign changes of acceleration",
    "velocity_sign_changes": "of velocity",
    "length_ratio": "length / straight",
    "time_ratio": "duration / least",
    "cpu_s": "CPU seconds",
}


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for motion.json and motion.md")] = _OUT,
    limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each run")] = 600.0,
    tasks: Annotated[int, typer.Option(min=0, help="tasks, in their order")] = len(_TASKS),
    machines: Annotated[int, typer.Option(min=0, help="random machines")] = 5,
) -> None:
    """Compare the motions of the former defaults with those of today."""
    host, rows = describe_host(), []
    for problem in motion_problems(tasks, machines):
        typer.echo(problem.name)
        rows.append(compare_defaults(problem, limit_s))
    write_page(out, host, rows)


def write_page(out: Path, host: dict[str, object], rows: list[dict[str, Any]]) -> None:
    """Write all figures, and the page."""
    write_whole(out / "motion.json", json_bytes({"host": host, "motions": rows}))
    write_whole(out / "motion.md", markdown(host, rows).encode())
    typer.echo(f"{out / 'motion.md'}")


def motion_problems(tasks: int, machines: int) -> list[Problem]:
    """Give the fixed tasks on the machine of `quick.yaml`, and its task on random machines."""
    base = load_config(CONFIGS / "quick.yaml").model_dump(mode="json")
    problems = []
    for name, start, goal, rest in _TASKS[:tasks]:
        document = copy.deepcopy(base)
        document["task"] |= {"start": _LEFT | start, "goal": _RIGHT | goal, **rest}
        problems.append(Problem(name, parse_config(document)))
    return [*problems, *random_machines(machines)]


def compare_defaults(problem: Problem, limit_s: float) -> dict[str, Any]:
    """Measure a problem with the former defaults and with those of today."""
    data = problem.config.model_dump(mode="json")
    former = parse_config({**data, **{section: data[section] | keys for section, keys in BEFORE.items()}})
    return {"problem": problem.name, "before": _measured(former, limit_s), "after": _measured(problem.config, limit_s)}


def _measured(config: Config, limit_s: float) -> dict[str, Any]:
    found = measure("tests.benchmarks.refining_motion:measure_run", (config,), limit_s)
    return found.figures if found.ended == FINISHED else {**found.figures, "outcome": found.ended}


def measure_run(config: Config) -> Iterator[dict[str, Any]]:
    """Plan, refine, prove and time a task, and check the path at ten times the usual density."""
    machine, begun = build_machine(config.machine), time.process_time()
    try:
        route = plan_route(config, machine, build_regions(config, machine))
        yield {"route_s": time.process_time() - begun}
        refined = time.process_time()
        result = refine_path(config, machine, route)
        path = result.path
        yield {"refine_s": time.process_time() - refined, "iterations": result.iterations}
        trajectory = retime_path(config, path)
    except NoSolutionError as error:
        yield {"outcome": f"no {error.stage}", "reason": error.reason}
        return
    yield {"cpu_s": time.process_time() - begun}
    figures = measure_path(sample_path(path, np.linspace(0.0, 1.0, 10_001)), step_sizes(config.route))
    ends = path.q(np.array([0.0, 1.0]))
    length_m = np.linalg.norm(np.diff(path.q(np.linspace(0.0, 1.0, 10_001)), axis=0), axis=1).sum()
    quality = measure_quality(trajectory)
    timing = trajectory.timing
    assert timing is not None, "a motion that was just planned has a report"
    yield {
        "kappa_integral": figures.kappa_integral,
        "kappa_max": figures.kappa_max,
        "modes": " ".join(figures.modes),
        "duration_s": timing.motion_s,
        "acceleration_sign_changes": sum(quality.acceleration_sign_changes),
        "velocity_sign_changes": sum(quality.velocity_sign_changes),
        "length_ratio": float(length_m / np.linalg.norm(ends[1] - ends[0])),
        "time_ratio": timing.motion_s / quality.least_time_s,
    }
    dense = config.model_copy(update={"refine": config.refine.model_copy(update={"check_points": CHECK_POINTS})})
    broken = find_violations(dense, route, path, result.coarse)
    yield {"outcome": "broken" if broken else "path", "reason": "; ".join(map(str, broken)), "certified": False}
    proof = config.model_copy(update={"certify": config.certify.model_copy(update={"what": "path"})})
    try:
        certify_path(proof, machine, path)
    except NoSolutionError as error:
        yield {"reason": error.reason}
        return
    yield {"certified": True}


def changes(rows: list[dict[str, Any]], key: str) -> list[float]:
    """Compute the relative changes of a figure from before to after, of the problems that have both, in order."""
    pairs = [(row["before"].get(key), row["after"].get(key)) for row in rows]
    return sorted(after / before - 1.0 for before, after in pairs if before and after is not None)


def markdown(host: dict[str, object], rows: list[dict[str, Any]]) -> str:
    """Write the comparison as a page."""
    summary = []
    for key, name in _COMPARED.items():
        if found := changes(rows, key):
            summary.append((name, *(f"{value:+.1%}" for value in (median(found), found[0], found[-1]))))
    kept, certified = (
        sum(row[side].get(key) == value for row in rows for side in ("before", "after"))
        for key, value in (("outcome", "path"), ("certified", True))
    )
    cells = [(row["problem"], *(_cell(row, key) for key in _COMPARED), _certified(row)) for row in rows]
    sections = [
        "# Motions before and after",
        "Written by `make bench-refine`; every number is in `motion.json`. Each run in a process of its own, on "
        f"{host['cpu']}, {host['cores']} cores, {host['date']}.",
        "Tasks on the grid of `quick.yaml`, and its task on machines up to five per cent off in every joint. *Before*: "
        "`route.objective: sum`, `refine.smoothness: 0`, `refine.corridor_cells: 1`; *after*: the defaults. Durations "
        "at full speed, not rounded to periods; sign changes of all five actuators together, above 5 % of the limit; "
        "length in actuator space against the straight line; duration against the least time of the slowest actuator "
        "alone; CPU seconds of stages one to three. "
        f"Of the {2 * len(rows)} paths of {len(rows)} problems {kept} keep every limit at {CHECK_POINTS:,} places, and "
        f"{certified} are certified.",
        table(("change", "median", "least", "largest"), summary),
        table(("problem", *_COMPARED.values(), "certified"), cells),
    ]
    return "\n\n".join(sections) + "\n"


def _cell(row: dict[str, Any], key: str) -> str:
    before, after = (_number(row[side], key) for side in ("before", "after"))
    return before if before == after else f"{before} → {after}"


def _number(figures: dict[str, Any], key: str) -> str:
    value = figures.get(key)
    if value is None:
        return "-" if figures.get("outcome", "path") == "path" else str(figures["outcome"])
    return str(value) if isinstance(value, int) else f"{value:.1f}" if value >= 100.0 else f"{value:.3g}"


def _certified(row: dict[str, Any]) -> str:
    verdicts = ["yes" if row[side].get("certified") else "NO" for side in ("before", "after")]
    return verdicts[0] if verdicts[0] == verdicts[1] else " → ".join(verdicts)


if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module.
    main()
