"""What a finer grid changes: the optimum of the reference task, and what the 3-DOF machine would have to pass.

The sum of kappa (5) counts regions, of which a finer grid has more on the same way: times the step it compares
between grids. The machine without tilt has no way but through a singularity. A grid lets it jump over, the closer the
finer it is: the least largest kappa of all its ways grows like one over the step, and no step is fine enough.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from pipeline.config import Config
from pipeline.machine import build_machine
from pipeline.route import build_regions
from pipeline.route.bounds.bottleneck import least_cap
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import find_moves, rule_moves
from tests.benchmarks.isolated import peak_mb

REFERENCE_STEP_M = 0.1


def measure_optimum(config: Config) -> Iterator[dict[str, Any]]:
    """Tell the least sum of kappa, also times the step, and the least largest kappa of all routes without x."""
    machine = build_machine(config.machine)
    regions = build_regions(config, machine)
    moves = find_moves(config, machine, regions)
    step_m = config.route.grid.y_m.step
    relaxation = shortest_paths(regions, moves, KappaSum()).optimum
    yield {
        "step_m": step_m,
        "regions": len(regions),
        "moves": len(moves),
        "relaxation": relaxation,
        "scaled": relaxation * step_m / REFERENCE_STEP_M,
        "bottleneck": least_cap(regions, moves),
        "peak_mb": peak_mb(),
    }


def measure_jump(config: Config) -> Iterator[dict[str, Any]]:
    """Tell the least largest kappa of all ways that (14)-(17) and (38) alone would admit, det H disregarded."""
    regions = build_regions(config, build_machine(config.machine))
    moves = rule_moves(config, regions)
    step_m = config.route.grid.y_m.step
    yield {
        "step_m": step_m,
        "regions": len(regions),
        "moves": len(moves),
        "bottleneck": least_cap(regions, moves),
        "peak_mb": peak_mb(),
    }


def growth_exponent(cases: list[dict[str, Any]]) -> float | None:
    """Fit bottleneck ~ step^-e over the cases that have a finite one: about 1 where a singularity is jumped over."""
    points = [(c["step_m"], c["bottleneck"]) for c in cases if np.isfinite(c.get("bottleneck", np.inf))]
    if len(points) < 2:
        return None
    step_m, kappa = np.array(points).T
    return -float(np.polyfit(np.log(step_m), np.log(kappa), 1)[0])
