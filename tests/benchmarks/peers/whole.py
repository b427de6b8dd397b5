"""The compact program and the paper's own, over all regions at once, in HiGHS."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline.progress import silent
from pipeline.route.metric import step_sizes
from pipeline.route.programs.compact import build_compact_model, read_compact
from pipeline.route.programs.paper import build_paper_model, read_paper
from pipeline.solvers.highs import solve_model, solver_name
from tests.benchmarks.exchange import load_exclusions, load_problem, load_regions
from tests.benchmarks.isolated import peak_mb


def compact(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the compact program."""
    return _solve(folder, limit_s, build_compact_model, read_compact)


def paper(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the paper's program, literally."""
    return _solve(folder, limit_s, build_paper_model, read_paper)


def _solve(folder: Path, limit_s: float, build: Any, read: Any) -> Iterator[dict[str, Any]]:
    options, regions, excluded = load_problem(folder).route, load_regions(folder), load_exclusions(folder)
    begin = time.perf_counter()
    model = build(regions, excluded, step_sizes(options), options.step_budget)
    built = time.perf_counter()
    told: dict[str, Any] = {"build_s": built - begin, "solver": solver_name()}
    told |= {"program_columns": model.lp_.num_col_, "program_rows": model.lp_.num_row_}
    yield told
    outcome = solve_model(model, limit_s, silent)
    told |= {"seconds": time.perf_counter() - built, "status": outcome.status.value, "bound": outcome.bound}
    told["peak_mb"] = peak_mb()
    if outcome.values.size:
        told["rows"], told["x_m"] = read(outcome.values, regions, options.step_budget)
    yield told
