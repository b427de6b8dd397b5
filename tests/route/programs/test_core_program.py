"""The mixed-integer program over the core."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.programs.core_program import build_core_program, read_core
from pipeline.route.programs.solution import solve_steps
from pipeline.status import Status


def _solve_core(core):
    return solve_steps(build_core_program(core), lambda values: read_core(values, core), 60.0)


@pytest.fixture(scope="module")
def solve(core_of):
    """Give a function that builds a core and solves the program over it, if there is one."""

    def build_and_solve(regions, moves, threshold, positions, x_step_m=1.0):
        core = core_of(regions, moves, shortest_paths(regions, moves, KappaSum()), threshold, positions, x_step_m)
        return core, (None if core.empty else _solve_core(core))

    return build_and_solve


def _assert_follows_rules(sequence, regions, moves, positions, x_step_m):
    """The start first, the goal last and once, moves or waits between, x in its windows and never too far."""
    region, x = sequence.region, sequence.x_m
    assert len(region) == len(x) <= positions
    assert region[0] == regions.start
    assert region[-1] == regions.goal
    assert regions.goal not in region[:-1]
    for i, j in zip(region.tolist(), region[1:].tolist(), strict=False):
        assert i == j or ((moves.source == i) & (moves.target == j)).any()
    windows = regions.x_window_m[region]
    assert (x >= windows[:, 0] - 1e-8).all()
    assert (x <= windows[:, 1] + 1e-8).all()
    assert (np.abs(np.diff(x)) <= x_step_m + 1e-8).all()
    assert regions.kappa[region[:-1]].sum() == pytest.approx(sequence.outcome.objective, abs=1e-6)


@settings(max_examples=60)
@given(st.integers(0, 1_000_000), st.booleans(), st.sampled_from([1.0, 1.0 - 4e-7, 0.7, 1.6]))
def test_optimum_is_that_of_a_dynamic_program(random_problem, cheapest, solve, seed, x_free, x_step_m):
    """With x binding or free, and with x_step just short of what windows ask for: the sums agree, rules hold."""
    regions, moves, positions = random_problem(seed, x_free)
    expected = cheapest(regions, moves, positions, x_step_m)
    # Any threshold that is high enough will do.
    core, sequence = solve(regions, moves, 20.0 * positions, positions, x_step_m)
    if not np.isfinite(expected):
        assert core.empty or sequence.outcome.status is Status.INFEASIBLE
        return
    assert sequence.outcome.status is Status.OPTIMAL
    assert sequence.outcome.gap == pytest.approx(0.0, abs=1e-9)
    assert sequence.outcome.objective == pytest.approx(expected, abs=1e-6)
    _assert_follows_rules(sequence, regions, moves, positions, x_step_m)


def test_x_decides_between_two_ways(hand_table, hand_moves, solve):
    """The cheap way is out of reach along X by a hair, so the costly one is taken."""
    windows = [(1.0 + 1e-6, 2.0), (0.5, 2.0), (0.0, 0.0), (1.5, 1.5)]
    regions = hand_table(windows, [3.0, 8.0, 5.0, 1.0])
    moves = hand_moves([(2, 0), (2, 1), (0, 3), (1, 3)])
    _, sequence = solve(regions, moves, 100.0, 3)
    assert sequence.region.tolist() == [2, 1, 3]
    assert sequence.outcome.objective == pytest.approx(13.0)
    _, sequence = solve(regions, moves, 100.0, 3, x_step_m=1.0 + 1e-6)
    assert sequence.region.tolist() == [2, 0, 3]


def test_waiting_is_part_of_the_sequence(hand_table, hand_moves, solve):
    """A step in which only x moves costs kappa of its region once more."""
    regions = hand_table([(0.0, 3.0), (0.0, 0.0), (3.0, 3.0)], [2.0, 7.0, 1.0])
    moves = hand_moves([(1, 0), (0, 2)])
    _, sequence = solve(regions, moves, 100.0, 7)
    assert sequence.region.tolist() == [1, 0, 0, 2]
    assert sequence.outcome.objective == pytest.approx(11.0)
    np.testing.assert_allclose(sequence.x_m, [0.0, 1.0, 2.0, 3.0], atol=1e-8)


def test_two_positions_are_enough_for_neighbours(hand_table, hand_moves, solve):
    """The smallest step budget there is: start and goal alone."""
    regions = hand_table([(0.0, 0.0), (0.5, 0.5)], [4.0, 9.0])
    _, sequence = solve(regions, hand_moves([(0, 1)]), 50.0, 2)
    assert sequence.region.tolist() == [0, 1]
    assert sequence.outcome.objective == pytest.approx(4.0)


def test_a_core_whose_hulls_hide_that_x_cannot_follow_is_proven_infeasible(hand_table, hand_moves, solve):
    """Into j lead x near -9, 0 and 9, out of it x near -5 and 5: the hulls overlap, the sets do not."""
    wide = (-10.0, 10.0)
    regions = hand_table([(-9.0, -9.0), (0.0, 0.0), (9.0, 9.0), wide, (-5.0, -5.0), (5.0, 5.0), wide, wide], [1.0] * 8)
    regions.x_window_m[-2:] = wide
    moves = hand_moves([(6, 0), (6, 1), (6, 2), (0, 3), (1, 3), (2, 3), (3, 4), (3, 5), (4, 7), (5, 7)])
    core, sequence = solve(regions, moves, 100.0, 5)
    assert not core.empty
    assert sequence.outcome.status is Status.INFEASIBLE
    assert len(sequence.region) == len(sequence.x_m) == 0
    assert sequence.outcome.objective == np.inf


def test_the_program_has_a_boolean_per_arc_and_a_position_per_step(cross, core_of):
    """Rows: a balance per node, two windows per step, and a difference between steps (13)."""
    bounds = shortest_paths(cross.regions, cross.moves, KappaSum())
    core = core_of(cross.regions, cross.moves, bounds, bounds.optimum * 1.01, 25, 0.1)
    program = build_core_program(core)
    assert program.columns == len(core.tail) + 25
    assert program.rows == len(core.step) + 25 + 25 + 24
    assert np.count_nonzero(program.integer) == len(core.tail)
    assert _solve_core(core).columns == program.columns


def test_the_reference_task_is_solved_to_the_known_optimum(cross, solve):
    """0.1 m, 10 degrees: x binds nowhere, so that the sum is that of the shortest path, 274.198822."""
    sequence = solve(cross.regions, cross.moves, 274.2 * 1.003, 25, 0.1)[1]
    assert sequence.outcome.objective == pytest.approx(274.198822, abs=1e-6)
    _assert_follows_rules(sequence, cross.regions, cross.moves, 25, 0.1)
