"""The same problems by every method, each in a process of its own with the same time limit, all answers judged."""

import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.arrays import FloatArray, IntArray
from pipeline.route import RegionTable
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.cost.objectives import route_cost
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves
from pipeline.route.search.rule_check import rule_violations
from tests.benchmarks.exchange import load_exclusions, load_problem, load_regions, save_config
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.problems import Problem

AGREEMENT = 1e-6
"""Largest relative difference between optima that counts as none."""
_TOLERANCE = 1e-5
"""How far, in metres, a peer's own feasibility tolerance may put x outside a rule."""
_OVERTIME = 1.05
"""Solvers look at the clock now and then; an answer later than this many time limits is none."""
_OVERHEAD_S = 120.0
"""Beyond the time limit of the solver: for starting, reading and building."""


@dataclass(frozen=True)
class Method:
    """A way to solve a problem; a peer knows the whole program and nothing of shortest paths."""

    name: str
    task: str
    peer: bool = True
    reads_program: bool = False


CORE = Method("core", "tests.benchmarks.peers.ours:core", peer=False)
METHODS = (
    CORE,
    Method("Dijkstra", "tests.benchmarks.peers.ours:shortest_path", peer=False),
    Method("compact, HiGHS", "tests.benchmarks.peers.whole:compact"),
    Method("compact, SCIP", "tests.benchmarks.peers.scip:compact", reads_program=True),
    Method("compact, CP-SAT", "tests.benchmarks.peers.cpsat:compact"),
    Method("compact, CBC", "tests.benchmarks.peers.cbc:compact", reads_program=True),
    Method("paper, HiGHS", "tests.benchmarks.peers.whole:paper"),
)


def compare(problems: Iterable[Problem], limit_s: float, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Solve problems, smallest first, by all methods.

    A peer that did not solve a problem within the limit is not tried on those with as many regions or more.
    """
    failed: dict[str, int] = {}
    return [_compare_one(problem, limit_s, failed, say) for problem in problems]


def _compare_one(
    problem: Problem, limit_s: float, failed: dict[str, int], say: Callable[[str], None]
) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        save_config(problem.config, folder)
        with_program = any(method.reads_program and method.name not in failed for method in METHODS)
        shared = measure("tests.benchmarks.exchange:prepare", (folder, with_program), 2 * _OVERHEAD_S)
        if shared.ended != FINISHED:
            return {"name": problem.name, "ended": shared.ended, "methods": {}}
        regions = shared.figures["regions"]
        judge = _Judge.of(folder)
        results = {}
        for method in METHODS:
            if method.name in failed:
                results[method.name] = {"status": f"not tried, not solved with {failed[method.name]:,} regions"}
                continue
            say(f"{problem.name} ({regions:,} regions): {method.name}")
            results[method.name] = _solve(method, folder, limit_s, judge)
            if method.peer and not _solved(results[method.name]):
                failed.setdefault(method.name, regions)
    return {"name": problem.name, **shared.figures, "methods": results, **_verdict(results)}


def _solve(method: Method, folder: Path, limit_s: float, judge: "_Judge") -> dict[str, Any]:
    found = measure(method.task, (folder, limit_s), limit_s + _OVERHEAD_S)
    told = dict(found.figures)
    if found.ended != FINISHED:
        told["status"] = found.ended
    if _solved(told) and told["seconds"] > limit_s * _OVERTIME:
        told["status"] = f"too late: {told['seconds']:.1f} s"
    if "rows" in told:
        rows, x = told.pop("rows"), told.pop("x_m")
        told |= {"objective": route_cost(KappaSum(), judge.regions, rows, x), "broken": judge.broken_rules(rows, x)}
    return told


def _solved(result: dict[str, Any]) -> bool:
    return result["status"] in ("optimal", "infeasible")


def _verdict(results: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Say whether all that claim an optimum name the same one, by a route that keeps all rules."""
    solved = [result for result in results.values() if _solved(result)]
    costs = np.array([result.get("objective", np.inf) for result in solved])
    kept = not any(result.get("broken") for result in solved)
    equal = len({result["status"] for result in solved}) == 1
    if equal and np.isfinite(costs).any():
        equal = bool(np.ptp(costs) <= AGREEMENT * costs.min())
    return {"agree": kept and equal, "optimum": float(costs.min()) if np.isfinite(costs).any() else None}


@dataclass(frozen=True, eq=False)
class _Judge:
    """Holds what a method returns against the rules alone."""

    regions: RegionTable
    excluded: Moves
    steps: FloatArray
    step_budget: int

    @classmethod
    def of(cls, folder: Path) -> "_Judge":
        route = load_problem(folder).route
        return cls(load_regions(folder), load_exclusions(folder), step_sizes(route), route.step_budget)

    def broken_rules(self, rows: IntArray, x_m: FloatArray) -> list[str]:
        """Name every rule that is broken, the excluded pairs among them."""
        broken = rule_violations(self.regions, rows, x_m, self.steps, self.step_budget, _TOLERANCE)
        pairs = set(zip(self.excluded.source.tolist(), self.excluded.target.tolist(), strict=True))
        used = zip(rows[:-1].tolist(), rows[1:].tolist(), strict=True)
        return broken + [f"the excluded move {pair}" for pair in used if pair in pairs]


def headline(instances: list[dict[str, Any]]) -> dict[str, Any] | None:
    """How many times faster the core is than the best peer, on the largest problem that any peer solves.

    A peer's seconds are those of its solver alone; the core's are moves, shortest paths, core and solver.
    """
    peers = [method.name for method in METHODS if method.peer]
    contested = []
    for instance in instances:
        seconds = {n: r["seconds"] for n, r in instance["methods"].items() if n in peers and _solved(r)}
        if seconds and _solved(instance["methods"][CORE.name]):
            contested.append((instance["regions"], instance, seconds))
    if not contested:
        return None
    largest = max(regions for regions, _, _ in contested)
    # Where several problems are of that size, the one the core does worst on.
    return min(
        (_ratio(instance, seconds) for n, instance, seconds in contested if n == largest), key=lambda r: r["ratio"]
    )


def _ratio(instance: dict[str, Any], seconds: dict[str, float]) -> dict[str, Any]:
    best = min(seconds, key=lambda name: seconds[name])
    core = instance["methods"][CORE.name]["seconds"]
    return {
        "problem": instance["name"],
        "regions": instance["regions"],
        "core_s": core,
        "best_peer": best,
        "best_peer_s": seconds[best],
        "ratio": seconds[best] / core,
    }
