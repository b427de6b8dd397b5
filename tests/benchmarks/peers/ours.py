"""Our own ways: the core, and the plain shortest path where it already is the answer."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config.choices import RouteObjective
from pipeline.machine import build_machine
from pipeline.route.bounds.shortest_paths import shortest_paths, shortest_route
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import find_moves
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.states import unexpanded_graph
from pipeline.solvers import solver_name
from tests.benchmarks.exchange import load_problem, load_regions
from tests.benchmarks.isolated import peak_mb


def core(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Prove the optimum on the core; moves and shortest paths count, too."""
    config, regions = load_problem(folder), load_regions(folder)
    limits = {"time_limit_s": limit_s, "objective": RouteObjective.SUM}
    config = config.model_copy(update={"route": config.route.model_copy(update=limits)})
    machine = build_machine(config.machine)
    begin = time.perf_counter()
    moves = find_moves(config, machine, regions)
    bounds = shortest_paths(regions, moves, KappaSum())
    problem = RouteProblem.of(config, machine, regions, moves)
    optimum = prove_on_core(problem, unexpanded_graph(regions, moves), bounds)
    told: dict[str, Any] = {"seconds": time.perf_counter() - begin, "solver": solver_name(), "peak_mb": peak_mb()}
    if optimum is None:
        yield told | {"status": "infeasible"}
        return
    sequence = optimum.sequence
    told |= {"status": sequence.outcome.status.value, "bound": optimum.bound}
    yield told | {"rows": sequence.region, "x_m": sequence.x_m, "program_columns": sequence.columns}


def shortest_path(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Find the shortest path, which is the optimum where it keeps to the step budget and some x goes with it."""
    del limit_s
    config, regions = load_problem(folder), load_regions(folder)
    machine = build_machine(config.machine)
    begin = time.perf_counter()
    moves = find_moves(config, machine, regions)
    rows = shortest_route(regions, moves, KappaSum(), shortest_paths(regions, moves, KappaSum()))
    x = place_along_x(regions.x_window_m[rows], config.route.x_step_m)
    told = {"seconds": time.perf_counter() - begin, "solver": "SciPy", "peak_mb": peak_mb()}
    if x is None or len(rows) > config.route.step_budget:
        yield told | {"status": "x or the step budget binds"}
        return
    yield told | {"status": "optimal", "rows": rows, "x_m": x}


def place_along_x(windows_m: FloatArray, x_step_m: float) -> FloatArray | None:
    """Choose x (n,) within windows (n, 2), at most `x_step_m` apart; None where there is no such x."""
    reach = [tuple(windows_m[0])]
    for low, high in windows_m[1:]:
        reach.append((max(low, reach[-1][0] - x_step_m), min(high, reach[-1][1] + x_step_m)))
    if any(low > high for low, high in reach):
        return None
    x = [reach[-1][0]]
    for low, high in reversed(reach[:-1]):
        x.append(min(max(x[-1], low), high))
    return np.array(x[::-1])
