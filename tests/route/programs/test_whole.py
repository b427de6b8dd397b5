"""The paper's program and the compact one: the same optima as the core and a dynamic program, on small problems."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config.choices import Formulation, RouteObjective
from pipeline.errors import NoSolutionError
from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route
from pipeline.route.bounds.budgets import task_budgets
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.cost.objectives import route_cost
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.programs.exclusions import add_exclusions, excluded_pairs
from pipeline.route.programs.paper import paper_size
from pipeline.route.programs.rows import Rows
from pipeline.route.programs.whole import WHOLE_PROGRAMS
from pipeline.route.search.objective import OBJECTIVES
from pipeline.route.search.rule_check import rule_violations
from pipeline.solvers import solve_program
from pipeline.status import Status

WIDE = np.array([1.0, 1e3, 1e3, 1e3, 1e3])
"""Steps that bind x alone: hand-made regions are a metre of y apart."""


def _all_but(regions, moves):
    """Exclude every pair of regions that is not a move."""
    admitted = set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))
    every = itertools.permutations(range(len(regions)), 2)
    pairs = np.array(sorted(set(every) - admitted), dtype=np.int64).reshape(-1, 2)
    return Moves(pairs[:, 0], pairs[:, 1])


@pytest.mark.parametrize("formulation", WHOLE_PROGRAMS)
@settings(max_examples=15)
@given(seed=st.integers(0, 1_000_000), x_free=st.booleans())
def test_optimum_is_that_of_a_dynamic_program(random_problem, cheapest, formulation, seed, x_free):
    """With x binding or free; what the program returns keeps the rules and costs what it says."""
    regions, moves, positions = random_problem(seed, x_free)
    positions = min(positions, 5)
    whole = WHOLE_PROGRAMS[formulation]
    expected = cheapest(regions, moves, positions, 1.0)
    outcome = solve_program(whole.build(regions, _all_but(regions, moves), WIDE, positions, ()), 60.0)
    if not np.isfinite(expected):
        assert outcome.status is Status.INFEASIBLE
        return
    assert outcome.status is Status.OPTIMAL
    assert outcome.objective == pytest.approx(expected, abs=1e-6)
    rows, x = whole.read(outcome.values, regions, positions)
    assert rule_violations(regions, rows, x, WIDE, positions) == []
    assert route_cost(KappaSum(), regions, rows, x) == pytest.approx(expected, abs=1e-6)


@pytest.fixture(scope="module")
def tiny(quick_config, vary):
    """Make a task of forty-seven regions: arm 1 has to pass its gate, two moves away."""
    config = vary(
        quick_config,
        {
            "task.start": {"x_m": 1.02, "y_m": 0.6, "z_m": 0.6, "mode": "LLL"},
            "task.goal": {"x_m": 1.0, "y_m": 0.6, "z_m": 0.6, "mode": "RLL"},
            "task.locked_axes": ["rx", "rz"],
            "route.grid.y_m": {"min": 0.5, "max": 0.7, "step": 0.1},
            "route.grid.z_m": {"min": 0.5, "max": 0.7, "step": 0.1},
            "route.step_budget": 4,
        },
    )
    machine = build_machine(config.machine)
    return config, machine, build_regions(config, machine)


@pytest.mark.parametrize("formulation", ["core", *WHOLE_PROGRAMS])
def test_a_route_is_planned_with_any_formulation(tiny, vary, assert_rules, formulation):
    """One truth: the same sum, followed and checked in the same way."""
    config, machine, regions = tiny
    config = vary(config, {"route.formulation": formulation})
    route = plan_route(config, machine, regions)
    assert_rules(config, machine, route)
    assert route.objective == pytest.approx(62.928150, abs=1e-6)
    assert route.search.gap == 0.0
    assert np.isfinite(route.search.threshold) == (formulation == "core")


@pytest.mark.parametrize("formulation", WHOLE_PROGRAMS)
def test_no_route_is_proven_with_any_formulation(tiny, vary, formulation):
    """From x 1.02 to 1.6 at 10 cm a step in four positions: the program itself says that it cannot be."""
    config, machine, _ = tiny
    config = vary(config, {"route.formulation": formulation, "task.goal.x_m": 1.6})
    with pytest.raises(NoSolutionError, match="proven"):
        plan_route(config, machine, build_regions(config, machine))


@pytest.mark.parametrize("formulation", WHOLE_PROGRAMS)
def test_a_time_limit_is_reported_as_such(tiny, vary, formulation):
    """No route in time: no proof, and no result."""
    config, machine, regions = tiny
    config = vary(config, {"route.formulation": formulation, "route.time_limit_s": 1e-6})
    with pytest.raises(NoSolutionError, match="no route was found within 1e-06 s, and none is proven to exist"):
        plan_route(config, machine, regions)


BUDGET = {"mode_changes": 2, "tilt_deg": 90.0, "travel_m": 1.0}


@pytest.mark.parametrize("formulation", WHOLE_PROGRAMS)
@pytest.mark.parametrize("budget", [{}, BUDGET])
def test_the_size_of_a_program_is_known_without_building_it(tiny, vary, formulation, budget):
    """Every column, row, boolean and entry is as in the program that is built."""
    config, machine, regions = tiny
    config = vary(config, {"task.budget": budget})
    exclusions = excluded_pairs(config, regions, find_moves(config, machine, regions))
    whole, N, budgets = WHOLE_PROGRAMS[formulation], config.route.step_budget, task_budgets(config)
    size = whole.size(len(regions), N, len(exclusions), len(np.unique(exclusions.source)), budgets)
    program = whole.build(regions, exclusions, step_sizes(config.route), N, budgets)
    assert size.columns == program.columns
    assert size.rows == program.rows
    assert size.booleans == np.count_nonzero(program.integer)
    # Coefficients that happen to be zero are counted, whether they are stored or not.
    assert program.matrix.nnz <= size.entries


def test_the_papers_program_has_a_column_per_step_and_region():
    """(13 + N_d) N of them: more than a million for the paper's own grid."""
    assert paper_size(45_936, 25).columns == 1_148_725


def test_exclusions_are_what_the_rules_admit_and_the_moves_do_not(small):
    """(14)-(17) and (38) alone admit them: among them are pairs with opposite signs of det H."""
    regions = small.regions
    exclusions = excluded_pairs(small.config, regions, small.moves)
    admitted = set(zip(small.moves.source.tolist(), small.moves.target.tolist(), strict=True))
    assert len(exclusions) > 100
    steps = step_sizes(small.config.route)[1:]
    apart = np.abs(regions.controlled[exclusions.source, 1:] - regions.controlled[exclusions.target, 1:])
    assert (apart <= steps + 1e-9).all()
    assert not admitted & set(zip(exclusions.source.tolist(), exclusions.target.tolist(), strict=True))
    opposite = regions.det_sign[exclusions.source] != regions.det_sign[exclusions.target]
    assert 0 < np.count_nonzero(opposite) < len(exclusions)


def test_nothing_may_be_excluded(tiny):
    """Where all that the rules admit are moves there is no row for the others."""
    _, _, regions = tiny
    rows = Rows(columns=2 * len(regions))
    add_exclusions(rows, Moves(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)), 0, len(regions))
    assert not rows.counts


def test_every_formulation_and_objective_of_the_configuration_is_known():
    """The core is one program per core; every other formulation, and every objective, is a row of a table."""
    assert set(Formulation) == {Formulation.CORE, *WHOLE_PROGRAMS}
    assert set(RouteObjective) == set(OBJECTIVES)
