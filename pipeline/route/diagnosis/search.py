"""Why there is no route: what the task and the limits ask for is relaxed, one at a time, until one exists.

The graph of a table with generous limits shows by bisection below which value the ends are not joined at all; from
there on the whole search, with x, step budget and moves followed, decides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order

from pipeline.arrays import BoolArray
from pipeline.config import BudgetConfig, Config
from pipeline.errors import NoSolutionError
from pipeline.limits import Relaxation, relaxations
from pipeline.limits.interface.relaxation import removals, with_values
from pipeline.machine.geometry import Machine
from pipeline.machine.rails import with_parallel_rails
from pipeline.progress import QUIET, Monitor, Progress
from pipeline.route.bounds.budgets import task_budgets
from pipeline.route.diagnosis.budgets import MOST_POSITIONS, BudgetSearch, relax_budget, relax_step_budget
from pipeline.route.diagnosis.endpoints import end_remarks
from pipeline.route.diagnosis.relaxed_table import RelaxedTable, WholeSearch, prefixed, search_whole
from pipeline.route.diagnosis.result import Finding, InfeasibilityReport, Verdict, make_finding
from pipeline.route.diagnosis.threshold import FeasibilityThreshold, find_threshold
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.regions.table import RegionTable

_MOST_PARTS = 20
"""Entries of a list of the task that are removed one by one, the first ones."""


@dataclass(frozen=True)
class _Attempt:
    """Something to relax: its key, that of the whole it is a part of, and how."""

    key: str
    part_of: str
    relax: Callable[[Progress], Finding]


def explain_infeasibility(
    config: Config,
    machine: Machine,
    regions: RegionTable,
    monitor: Monitor = QUIET,
    limits: Sequence[Relaxation] | None = None,
) -> InfeasibilityReport:
    """Find out what prevents a route that `plan_route` could not find on `regions`.

    Every finding is about one thing alone, all others as configured, on the same grid: what the task asks for, and
    `limits`, all by default. What cannot matter is left out: budgets where no moves join start and goal at any cost,
    and entries of a list that does not help as a whole. Ctrl-C ends the search, and keeps what was found.
    """
    progress, machine = monitor.progress, with_parallel_rails(machine)
    limits = relaxations(config, machine) if limits is None else limits
    moves = find_moves(config, machine, regions, Monitor(prefixed(progress, "as configured")))
    from_start = reached(moves, len(regions), regions.start)
    joined = bool(from_start[regions.goal])
    attempts = _attempts(config, machine, limits)
    if joined:
        attempts = _budget_attempts(BudgetSearch.of(config, machine, regions, moves)) + attempts
    findings, not_tried = _try_all(attempts, progress)
    if not not_tried and not any(finding.verdict is Verdict.OPENS for finding in findings):
        more, not_tried = _try_all(_together(config, machine), progress)
        findings += more
    return InfeasibilityReport(
        remarks=tuple(end_remarks(config, machine, regions, moves)),
        findings=tuple(findings),
        from_start=from_start,
        to_goal=reached(moves, len(regions), regions.goal, backwards=True),
        not_tried=tuple(not_tried),
    )


def _try_all(attempts: list[_Attempt], progress: Progress) -> tuple[list[Finding], list[str]]:
    """Relax one after the other; also the keys of those that Ctrl-C left out."""
    findings: list[Finding] = []
    never: set[str] = set()
    number = 0
    try:
        for number, attempt in enumerate(attempts):
            if attempt.part_of in never:
                continue
            finding = attempt.relax(prefixed(progress, _place(number, len(attempts), findings)))
            findings.append(finding)
            if finding.verdict is Verdict.NEVER:
                never.add(attempt.key)
    except KeyboardInterrupt:
        return findings, [attempt.key for attempt in attempts[number:] if attempt.part_of not in never]
    return findings, []


def _place(number: int, count: int, findings: list[Finding]) -> str:
    """Say how far the search is, and what an interrupt would keep."""
    opening = sum(finding.verdict is Verdict.OPENS for finding in findings)
    return f"{number + 1} of {count}" + (f" ({opening} found that open a route; Ctrl-C keeps them)" if opening else "")


def _attempts(config: Config, machine: Machine, limits: Sequence[Relaxation]) -> list[_Attempt]:
    """List what the task asks for, then the limits of the machine."""
    many = [*removals(config, "visit"), *limits]
    parts = [relaxation for relaxation in many if relaxation.part_of]
    left_out = [
        part for part in parts if sum(p.part_of == part.part_of for p in parts[: parts.index(part)]) >= _MOST_PARTS
    ]
    kept = sorted((one for one in many if one not in left_out), key=lambda one: not one.removes)
    return [_Attempt(one.key, one.part_of, partial(relax_limit, config, machine, one)) for one in kept]


def _budget_attempts(search: BudgetSearch) -> list[_Attempt]:
    """List the budgets, where they can matter."""
    found = [
        _Attempt(f"task.budget.{budget.key}", "", partial(relax_budget, search, budget))
        for budget in task_budgets(search.config)
    ]
    if search.config.route.step_budget < MOST_POSITIONS:
        found.append(_Attempt("route.step_budget", "", partial(relax_step_budget, search)))
    return found


def _together(config: Config, machine: Machine) -> list[_Attempt]:
    """Remove at a time everything that the task asks for beside start and goal, if that is more than one thing."""
    task = config.task
    asked = [f"task.{key}" for key in ("visit", "avoid") if getattr(task, key)]
    asked += [f"task.budget.{budget.key}" for budget in task_budgets(config)]
    if len(asked) < 2:
        return []
    without = with_values(config, "task", visit=(), avoid=(), budget=BudgetConfig())
    both = Relaxation.removal(f"{', '.join(asked[:-1])} and {asked[-1]}", without)
    return [_Attempt(both.key, "", partial(relax_limit, config, machine, both))]


def reached(moves: Moves, count: int, root: int, backwards: bool = False) -> BoolArray:
    """Mark the regions (count,) that can be reached from region `root`, or from which it can be reached."""
    graph = moves.graph(np.ones(len(moves)), count)
    found = np.zeros(count, dtype=bool)
    found[breadth_first_order(csr_array(graph.T) if backwards else graph, root, return_predecessors=False)] = True
    return found


def relax_limit(
    config: Config, machine: Machine, relaxation: Relaxation, progress: Progress, run: WholeSearch = search_whole
) -> Finding:
    """Relax one limit, part by part of its values, until a route exists."""
    threshold = FeasibilityThreshold(refused=0, by_graph=False)
    for begin, end in pairwise((0, *relaxation.segments)):
        try:
            wide = RelaxedTable.build(machine, relaxation, end, config.route, progress)
        except NoSolutionError:
            # A table beyond the memory allowed, or with a visit out of reach, shows nothing: what is known stays.
            break
        first = wide.first_joined(begin, end)
        if first > begin:
            threshold = FeasibilityThreshold(refused=first - 1, by_graph=True)
        if first < end:
            threshold = find_threshold(threshold, max(first, threshold.refused + 1), end, partial(wide.search, run=run))
        if threshold.opened is not None:
            break
    return make_finding(
        relaxation.key,
        relaxation.configured,
        relaxation.levels,
        threshold,
        locked_axes=relaxation.locked_axes,
        removes=relaxation.removes,
    )
