"""One truth: core, paper's program, compact program and brute force, with all that a task may ask for, by objective."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from pipeline.config import Config
from pipeline.config.choices import RouteObjective
from pipeline.machine import Machine
from pipeline.route.bounds.budgets import task_budgets
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.cost.actuator_time import ActuatorTime
from pipeline.route.cost.interface import MoveCost
from pipeline.route.cost.kappa_integral import KappaIntegral
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.regions.table import RegionTable
from pipeline.route.search.objective import find_best
from pipeline.route.search.rule_check import rule_violations, task_violations
from pipeline.route.search.states import expand_states
from pipeline.solvers import solve_program
from pipeline.status import Status

WIDE = np.array([1.0, 1e3, 1e3, 1e3, 1e3])
COSTS: dict[RouteObjective, MoveCost] = {
    RouteObjective.INTEGRAL: KappaIntegral(np.array([1.0, 0.5, 0.5, 0.5, 0.5])),
    RouteObjective.SUM: KappaSum(),
    RouteObjective.BOTTLENECK: KappaSum(),
    RouteObjective.TIME: ActuatorTime(np.array([0.5, 0.4, 0.5, 0.2, 0.3]), 1.0),
}


@dataclass(frozen=True, eq=False)
class Case:
    """A made-up problem with what is asked of its route."""

    config: Config
    regions: RegionTable
    moves: Moves
    near: np.ndarray
    positions: int


@pytest.fixture(scope="module")
def draw(random_problem, hand_moves, quick_config, vary):
    """Give a function that draws a problem: gates of arm 1, tilts, visits, budgets, routes to stray from."""

    def problem(seed, asked) -> Case:
        regions, moves, positions = random_problem(seed)
        random = np.random.default_rng(seed)
        n, positions = len(regions), min(positions + 1, 5)
        gate = (random.random(n) < 0.7).astype(np.int64)
        mode = np.where(random.random(n) < 0.4, 4, 0)
        low = random.integers(-2, 2, n)
        windows = np.column_stack([low, low + random.integers(0, 4, n)]).astype(float)
        windows[-2:, 1] = windows[-2:, 0]
        controlled = regions.controlled.copy()
        controlled[-2:, 0] = windows[-2:, 0]
        controlled[:, 1:3] = random.integers(0, 3, (n, 2)) / 10.0
        controlled[:, 3:] = random.integers(-2, 3, (n, 2)) / 10.0
        visit = np.zeros(n, dtype=np.int64)
        budget: dict[str, float] = {}
        near = np.zeros((0, n), dtype=bool)
        visits = []
        if "visit" in asked:
            visit[:-2] = random.choice([0, 1, 1, 2], n - 2)
            visits = [{"box": {"x_m": [-9, 9]}}] * int(visit.max())
        if "budget" in asked:
            budget["mode_changes"] = int(random.integers(0, 4))
            budget["tilt_deg"] = float(np.rad2deg(random.integers(2, 20) / 10.0))
        if "travel" in asked:
            budget["travel_m"] = float(random.integers(1, 8) / 2.0)
        if "stray" in asked:
            near = random.random((2, n)) < 0.7
            near[:, -2:] = True
        q_m = random.uniform(-0.5, 0.5, (n, 5))
        q_m[-2:, :3] += controlled[-2:, :1]
        table = replace(
            regions, gates=gate, modes=mode, controlled=controlled, visits=visit, x_window_m=windows, q_m=q_m
        )
        kept = [
            (i, j)
            for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True)
            if mode[i] == mode[j] or gate[i] == 1
        ]
        values = {"route.x_step_m": 1.0, "route.step_budget": positions, "task.budget": budget, "task.visit": visits}
        return Case(vary(quick_config, values), table, hand_moves(kept), near, positions)

    return problem


def _sequences(case: Case) -> list[np.ndarray]:
    """Give all sequences, waits included, that fulfil what is asked but for x."""
    onwards = {i: [i] for i in range(len(case.regions))}
    for i, j in zip(case.moves.source.tolist(), case.moves.target.tolist(), strict=True):
        onwards[i].append(j)
    onwards[case.regions.goal] = [case.regions.goal]
    sequences = [[case.regions.start]]
    for _ in range(case.positions - 1):
        sequences = [[*sequence, j] for sequence in sequences for j in onwards[sequence[-1]]]
    return [s for s in map(np.array, sequences) if s[-1] == case.regions.goal and _asked(case, s)]


def _brute_force(case: Case) -> float:
    """The least sum (5): all sequences, the cheapest first; x of those that keep all else by a linear program."""
    return _least_pair(case, lambda sequence: 0.0)[1]


def _least_pair(case: Case, first: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """Give the least of what comes first, and then the least sum; infinite without a route."""
    kappa = case.regions.kappa.copy()
    kappa[case.regions.goal] = 0.0
    found = [(first(s), float(kappa[s].sum()), s) for s in _sequences(case)]
    for largest, total, sequence in sorted(found, key=lambda item: item[:2]):
        if _travels(case, sequence):
            return largest, total
    return np.inf, np.inf


def _least_cost(case: Case, cost: MoveCost) -> float:
    """All sequences by what they cost at least for any x; their best x by linear programs of tangents."""
    dx = np.linspace(-1.0, 1.0, 41)
    pairs = np.indices((len(case.regions), len(case.regions))).reshape(2, -1)
    table = np.array([cost.at(case.regions, *pairs, np.full(pairs.shape[1], d)) for d in dx])
    # A convex cost is least between the points of a grid by no more than its rise over one of them.
    lower = (table.min(axis=0) - np.abs(np.diff(table, axis=0)).max(axis=0)).reshape(len(case.regions), -1)
    lower[case.regions.goal, case.regions.goal] = 0.0
    found = [(float(lower[s[:-1], s[1:]].sum()), s) for s in _sequences(case)]
    best = np.inf
    for least, sequence in sorted(found, key=lambda item: item[0]):
        if least >= best:
            break
        best = min(best, _cost_of(case, cost, sequence, best))
    return best


def _cost_of(case: Case, cost: MoveCost, rows: np.ndarray, enough: float) -> float:
    """Choose x by tangents until they meet the cost, or show that it is not below `enough`."""
    n, ends = len(rows), (case.regions, rows[:-1], rows[1:])
    difference, eye, none = np.diff(np.eye(n), axis=0), np.eye(n - 1), np.zeros((n - 1, n - 1))
    travels = [np.full(n - 1, dx) for dx in np.linspace(-1.0, 1.0, 9)]
    limit = case.config.task.budget.travel_m
    across = np.abs(np.diff(case.regions.controlled[rows, 1:3], axis=0)).sum()
    most = np.inf if limit is None else limit - across
    while True:
        tangents = [cost.tangent(*ends, dx) for dx in travels]
        solution = linprog(
            np.concatenate([np.zeros(n), np.ones(n - 1), np.zeros(n - 1)]),
            A_ub=np.vstack(
                [np.hstack([sign * difference, none, -eye]) for sign in (1.0, -1.0)]
                + [np.hstack([slope[:, None] * difference, -eye, none]) for _, slope in tangents]
                + [np.concatenate([np.zeros(2 * n - 1), np.ones(n - 1)])]
            ),
            b_ub=np.concatenate(
                [np.zeros(2 * (n - 1)), *(-constant for constant, _ in tangents), [min(most, 1e3) + 1e-9]]
            ),
            bounds=[*case.regions.x_window_m[rows].tolist(), *([(None, None)] * (n - 1)), *([(0.0, 1.0)] * (n - 1))],
        )
        if not solution.success or solution.fun >= enough:
            return np.inf
        dx = np.diff(solution.x[:n])
        total = float(cost.at(*ends, dx).sum())
        if total - solution.fun <= 1e-8 * total + 1e-9:
            return total
        travels.append(dx)


def _asked(case: Case, sequence: np.ndarray) -> bool:
    """Visits in turn, every better route strayed from, budgets but for travel kept."""
    wanted = iter(case.regions.visits[sequence].tolist())
    if not all(k in wanted for k in range(1, int(case.regions.visits.max()) + 1)):
        return False
    if not (~case.near[:, sequence]).any(axis=1).all():
        return False
    limits, tilts = case.config.task.budget, case.regions.controlled[sequence, 3:]
    changes = np.count_nonzero(np.diff(case.regions.modes[sequence]))
    if limits.mode_changes is not None and changes > limits.mode_changes:
        return False
    return limits.tilt_deg is None or np.rad2deg(np.abs(np.diff(tilts, axis=0)).sum()) <= limits.tilt_deg + 1e-6


def _travels(case: Case, sequence: np.ndarray) -> bool:
    """Tell whether the least travel along X over the windows, at most a metre a step, is within the budget."""
    n = len(sequence)
    difference = np.diff(np.eye(n), axis=0)
    eye = np.eye(n - 1)
    solution = linprog(
        np.append(np.zeros(n), np.ones(n - 1)),
        A_ub=np.block([[difference, -eye], [-difference, -eye]]),
        b_ub=np.zeros(2 * (n - 1)),
        bounds=[*case.regions.x_window_m[sequence].tolist(), *([(0.0, 1.0)] * (n - 1))],
    )
    if not solution.success:
        return False
    limit = case.config.task.budget.travel_m
    across = np.abs(np.diff(case.regions.controlled[sequence, 1:3], axis=0)).sum()
    return limit is None or solution.fun + across <= limit + 1e-9


SEED, MARGIN = st.integers(0, 1_000_000), st.sampled_from([1e-6, 0.002, 1.0])
ASKED = st.sets(st.sampled_from(["visit", "budget", "travel", "stray"]))


def _expected(case: Case, objective: str, cost: MoveCost) -> tuple[float, float]:
    """Give what comes first, the largest kappa where it counts, and the cost."""
    if objective == "bottleneck":
        return _least_pair(case, lambda sequence: float(case.regions.kappa[sequence].max()))
    return (0.0, _brute_force(case)) if objective == "sum" else (0.0, _least_cost(case, cost))


@pytest.mark.parametrize("objective", [RouteObjective.SUM, RouteObjective.BOTTLENECK])
@settings(max_examples=115)
@given(seed=SEED, asked=ASKED, margin=MARGIN)
def test_the_core_finds_the_optimum_of_brute_force(draw, vary, machine, objective, seed, asked, margin):
    """Whatever is asked of the route and whatever the first threshold; what it finds keeps all rules."""
    _agree(draw(seed, asked), vary, machine, objective, margin)


@pytest.mark.parametrize("objective", [RouteObjective.INTEGRAL, RouteObjective.TIME])
@settings(max_examples=35)
@given(seed=SEED, asked=ASKED, margin=MARGIN)
def test_so_it_does_where_travel_along_x_costs(draw, vary, machine, objective, seed, asked, margin):
    """The best x of every sequence is part of the brute force, which takes longer."""
    _agree(draw(seed, asked), vary, machine, objective, margin)


def _agree(case: Case, vary, machine: Machine, objective: RouteObjective, margin: float) -> None:
    config = vary(case.config, {"route.threshold_margin": margin, "route.objective": objective.value})
    graph = expand_states(case.regions, case.moves, case.near)
    cost = COSTS[objective]
    problem = replace(RouteProblem.of(config, machine, case.regions, case.moves), cost=cost)
    bounds = priced_bounds(graph.regions, graph.moves, cost, problem.budgets)
    largest, expected = _expected(case, objective, cost)
    # Of a route within the budgets and all else the bounds promise no more than it costs.
    assert bounds.optimum <= expected + 1e-9
    screen = Screen(lambda source, target: [None] * len(source), len(case.regions))
    optimum = find_best(problem, graph, bounds, screen)
    if not np.isfinite(expected):
        assert optimum is None
        return
    assert optimum.objective == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert optimum.proven
    rows = optimum.sequence.region
    assert objective != "bottleneck" or case.regions.kappa[rows].max() == largest
    assert rule_violations(case.regions, rows, optimum.sequence.x_m, WIDE, case.positions) == []
    assert task_violations(config, case.regions, rows, optimum.sequence.x_m) == []
    assert (~case.near[:, rows]).any(axis=1).all()


@pytest.mark.parametrize("formulation", WHOLE_PROGRAMS)
@settings(max_examples=25)
@given(seed=st.integers(0, 1_000_000), asked=ASKED)
def test_the_other_programs_find_the_optimum_of_brute_force(draw, formulation, seed, asked):
    """Budgets are rows and columns there, and nothing is priced."""
    case = draw(seed, asked)
    graph = expand_states(case.regions, case.moves, case.near)
    whole = WHOLE_PROGRAMS[formulation]
    every = itertools.permutations(range(len(graph.regions)), 2)
    admitted = set(zip(graph.moves.source.tolist(), graph.moves.target.tolist(), strict=True))
    excluded = np.array(sorted(set(every) - admitted), dtype=np.int64).reshape(-1, 2)
    program = whole.build(graph.regions, Moves(*excluded.T), WIDE, case.positions, task_budgets(case.config))
    outcome = solve_program(program, 60.0)
    expected = _brute_force(case)
    if not np.isfinite(expected):
        assert outcome.status is Status.INFEASIBLE
        return
    assert outcome.objective == pytest.approx(expected, abs=1e-6)
    rows, x = whole.read(outcome.values, graph.regions, case.positions)
    assert task_violations(case.config, case.regions, graph.base[rows], x) == []
