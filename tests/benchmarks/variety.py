"""Random tasks on the reference machine and the reference task on random machines: how often stage two has a path."""

import copy
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine import build_machine
from pipeline.machine.geometry import MODES
from pipeline.refine import measure_path, refine_path, sample_path
from pipeline.refine.check import find_violations
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes
from tests.benchmarks.problems import CONFIGS, Problem

CHECK_POINTS = 100_000
_POINTS = ("l1", "l2a", "l2b", "l3a", "l3b", "l3c")


def random_tasks(count: int, seed: int = 1) -> Iterator[Problem]:
    """Draw tasks whose start and goal the reference machine can be in, in different working modes or places."""
    base, rng = load_config(CONFIGS / "quick.yaml").model_dump(mode="json"), np.random.default_rng(seed)
    found = 0
    while found < count:
        document = copy.deepcopy(base)
        x = rng.uniform(0.8, 1.3)
        for end in ("start", "goal"):
            document["task"][end] = {
                "x_m": round(x + rng.uniform(-0.15, 0.15), 3),
                "y_m": round(rng.uniform(0.0, 0.9), 3),
                "z_m": round(rng.uniform(0.5, 1.2), 3),
                "rx_deg": round(rng.uniform(-10.0, 10.0), 1),
                "rz_deg": round(rng.uniform(-10.0, 10.0), 1),
                "mode": MODES[rng.integers(8)],
            }
        document["name"] = f"task-{found + 1}"
        config = parse_config(document)
        try:
            build_regions(config, build_machine(config.machine))
        except (ConfigError, NoSolutionError):
            continue
        found += 1
        yield Problem(f"task {found}: {_words(config)}", config)


def random_machines(count: int, seed: int = 2) -> Iterator[Problem]:
    """Draw machines whose joints, lengths and rails are up to five per cent off, for the reference task."""
    base, rng = load_config(CONFIGS / "quick.yaml").model_dump(mode="json"), np.random.default_rng(seed)
    found = 0
    while found < count:
        document = copy.deepcopy(base)
        links = document["machine"]["links"]
        for name in _POINTS:
            point = np.array(links[name]["platform_point_m"])
            links[name]["platform_point_m"] = (point * rng.uniform(0.95, 1.05, 3)).round(4).tolist()
        for name in ("l1", "l2a", "l3a"):
            links[name]["length_m"] = round(links[name]["length_m"] * rng.uniform(0.97, 1.05), 4)
        document["machine"]["rails"][1]["y_m"] = round(0.75 * rng.uniform(0.95, 1.05), 4)
        document["name"] = f"machine-{found + 1}"
        try:
            config = parse_config(document)
            build_regions(config, build_machine(config.machine))
        except (ConfigError, NoSolutionError):
            continue
        found += 1
        yield Problem(f"machine {found}", config)


def measure_refinement(config: Config) -> Iterator[dict[str, Any]]:
    """Tell how stage one and stage two end, and what the path still breaks at ten times the usual density."""
    machine, steps = build_machine(config.machine), step_sizes(config.route)
    try:
        route = plan_route(config, machine, build_regions(config, machine))
    except NoSolutionError as error:
        yield {"outcome": "no route", "reason": error.reason}
        return
    yield {"positions": len(route)}
    begun = time.perf_counter()
    try:
        result = refine_path(config, machine, route)
    except NoSolutionError as error:
        yield {"outcome": "no path", "reason": error.reason, "refine_s": time.perf_counter() - begun}
        return
    yield {"refine_s": time.perf_counter() - begun, "iterations": result.iterations, "rounds": result.rounds}
    dense = config.model_copy(update={"refine": config.refine.model_copy(update={"check_points": CHECK_POINTS})})
    broken = find_violations(dense, route, result.path, result.coarse)
    coarse, fine = (
        measure_path(sample_path(path, np.linspace(0.0, 1.0, 10_001)), steps) for path in (result.coarse, result.path)
    )
    yield {
        "outcome": "broken" if broken else "path",
        "reason": "; ".join(map(str, broken)),
        "nodes": result.nodes,
        "kappa_integral": fine.kappa_integral,
        "kappa_integral_change": fine.kappa_integral / coarse.kappa_integral - 1.0,
        "kappa_max": fine.kappa_max,
        "coarse_kappa_max": coarse.kappa_max,
    }


def _words(config: Config) -> str:
    ends = (config.task.start, config.task.goal)
    return " to ".join(f"{end.mode} ({end.x_m:g}, {end.y_m:g}, {end.z_m:g})" for end in ends)
