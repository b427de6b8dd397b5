"""The compact program and the paper's own, over all regions at once, in HiGHS."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline.route.metric import step_sizes
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.solvers import solve_program, solver_name
from tests.benchmarks.exchange import load_exclusions, load_problem, load_regions
from tests.benchmarks.isolated import peak_mb


def compact(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the compact program."""
    return _solve(folder, limit_s, "compact")


def paper(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the paper's program, literally."""
    return _solve(folder, limit_s, "paper")


def _solve(folder: Path, limit_s: float, formulation: str) -> Iterator[dict[str, Any]]:
    options, regions, excluded = load_problem(folder).route, load_regions(folder), load_exclusions(folder)
    whole = WHOLE_PROGRAMS[formulation]
    begin = time.perf_counter()
    program = whole.build(regions, excluded, step_sizes(options), options.step_budget, ())
    built = time.perf_counter()
    told: dict[str, Any] = {"build_s": built - begin, "solver": solver_name()}
    told |= {"program_columns": program.columns, "program_rows": program.rows}
    yield told
    outcome = solve_program(program, limit_s)
    told |= {"seconds": time.perf_counter() - built, "status": outcome.status.value, "bound": outcome.bound}
    told["peak_mb"] = peak_mb()
    if outcome.values.size:
        told["rows"], told["x_m"] = whole.read(outcome.values, regions, options.step_budget)
    yield told
