"""One truth, four ways: core, paper's program, compact program and brute force, with everything a task may ask for."""

import itertools
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from pipeline.config import Config
from pipeline.route.bounds.budgets import task_budgets
from pipeline.route.bounds.prices import priced_bounds
from pipeline.route.moves.candidates import Moves
from pipeline.route.problem import RouteProblem
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.regions.table import RegionTable
from pipeline.route.search.optimum import prove_on_core
from pipeline.route.search.rule_check import rule_violations, task_violations
from pipeline.route.search.states import expand_states
from pipeline.solvers import solve_program
from pipeline.status import Status

WIDE = np.array([1.0, 1e3, 1e3, 1e3, 1e3])


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
        table = replace(regions, gates=gate, modes=mode, controlled=controlled, visits=visit, x_window_m=windows)
        kept = [
            (i, j)
            for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True)
            if mode[i] == mode[j] or gate[i] == 1
        ]
        values = {"route.x_step_m": 1.0, "route.step_budget": positions, "task.budget": budget, "task.visit": visits}
        return Case(vary(quick_config, values), table, hand_moves(kept), near, positions)

    return problem


def _brute_force(case: Case) -> float:
    """All sequences, the cheapest first; x of those that keep all else by a linear program."""
    onwards = {i: [i] for i in range(len(case.regions))}
    for i, j in zip(case.moves.source.tolist(), case.moves.target.tolist(), strict=True):
        onwards[i].append(j)
    onwards[case.regions.goal] = [case.regions.goal]
    sequences = [[case.regions.start]]
    for _ in range(case.positions - 1):
        sequences = [[*sequence, j] for sequence in sequences for j in onwards[sequence[-1]]]
    kappa = case.regions.kappa.copy()
    kappa[case.regions.goal] = 0.0
    found = [(kappa[s].sum(), s) for s in map(np.array, sequences) if s[-1] == case.regions.goal and _asked(case, s)]
    for cost, sequence in sorted(found, key=lambda item: item[0]):
        if _travels(case, sequence):
            return float(cost)
    return np.inf


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


ASKED = st.sets(st.sampled_from(["visit", "budget", "travel", "stray"]))


@settings(max_examples=300)
@given(seed=st.integers(0, 1_000_000), asked=ASKED, margin=st.sampled_from([1e-6, 0.002, 1.0]))
def test_the_core_finds_the_optimum_of_brute_force(draw, vary, machine, seed, asked, margin):
    """Whatever is asked of the route and whatever the first threshold; what it finds keeps all rules."""
    case = draw(seed, asked)
    config = vary(case.config, {"route.threshold_margin": margin})
    graph = expand_states(case.regions, case.moves, case.near)
    problem = RouteProblem.of(config, machine, case.regions, case.moves)
    bounds = priced_bounds(graph.regions, graph.moves, problem.cost, problem.budgets)
    expected = _brute_force(case)
    # Of a route within the budgets and all else the bounds promise no more than it costs.
    assert bounds.optimum <= expected + 1e-9
    optimum = prove_on_core(problem, graph, bounds)
    if not np.isfinite(expected):
        assert optimum is None
        return
    assert optimum.objective == pytest.approx(expected, abs=1e-6)
    rows = optimum.sequence.region
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
