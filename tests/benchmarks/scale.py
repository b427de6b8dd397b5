"""Stage one by the size of its grid: seconds of every part, peak memory, and the region table against its limit."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine, build_machine
from pipeline.machine.statics import statics_matrix
from pipeline.route import RegionTable, build_regions, plan_route
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.moves.candidates import find_moves
from pipeline.route.problem import RouteProblem
from pipeline.route.search.optimum import find_optimum
from pipeline.route.search.states import unexpanded_graph
from tests.benchmarks.isolated import peak_mb, stopwatch

PARTS = ("regions_s", "moves_s", "relaxation_s", "solve_s")


def measure_parts(config: Config) -> Iterator[dict[str, Any]]:
    """Measure stage one on a configuration; figures are told as they come."""
    machine = build_machine(config.machine)
    told: dict[str, Any] = {"step_budget": config.route.step_budget}
    with stopwatch(told, "regions_s"):
        regions = build_regions(config, machine)
    told |= {"regions": len(regions), "gates": regions.gate_count}
    told["nominal_variables"] = (13 + len(regions)) * config.route.step_budget
    yield told | {"peak_mb": peak_mb()}
    with stopwatch(told, "moves_s"):
        moves = find_moves(config, machine, regions)
    yield told | {"moves": len(moves), "peak_mb": peak_mb()}
    with stopwatch(told, "relaxation_s"):
        problem = RouteProblem.of(config, machine, regions, moves)
        bounds = priced_bounds(regions, moves, problem.cost, problem.budgets)
    yield told | {"relaxation": bounds.optimum, "peak_mb": peak_mb()}
    with stopwatch(told, "solve_s"):
        optimum = find_optimum(problem, unexpanded_graph(regions, moves), bounds)
    told["total_s"] = sum(told[part] for part in PARTS)
    if optimum is None:
        yield told | {"status": "infeasible", "peak_mb": peak_mb()}
        return
    told |= {
        "status": optimum.sequence.outcome.status.value,
        "objective": optimum.objective,
        "gap": optimum.sequence.outcome.gap,
        "threshold": optimum.threshold,
        "core_regions": optimum.regions,
        "core_columns": optimum.sequence.columns,
        "peak_mb": peak_mb(),
    }
    yield told
    del moves, bounds, problem
    with stopwatch(told, "followed_s"):
        followed = _followed(config, machine, regions)
    told["followed_s"] += told["regions_s"]
    told |= followed | {"peak_mb": peak_mb()}
    yield told
    H = statics_matrix(machine, regions.pose, regions.q_m[:, :3])
    with stopwatch(told, "svd_s"):
        np.linalg.svd(H, compute_uv=False)
    yield told


def _followed(config: Config, machine: Machine, regions: RegionTable) -> dict[str, Any]:
    """Plan a route whose every move holds when followed; grids far too coarse have none."""
    try:
        route = plan_route(config, machine, regions)
    except NoSolutionError as error:
        return {"not_followed": error.reason}
    return {"followed_objective": route.objective, "rounds": route.search.rounds}
