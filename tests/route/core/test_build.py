"""The core: nothing that belongs to a route of at most T is left out."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.route.bounds.shortest_paths import cheap_moves, shortest_paths
from pipeline.route.core.build import core_bytes
from pipeline.route.cost.kappa_sum import KappaSum


def _cheapest_in(core, step_budget):
    """The least cost from the first node to the last along arcs, x ignored: a bound on the program over the core."""
    cost = np.full(len(core.step), np.inf)
    cost[0] = 0.0
    for i in range(step_budget - 1):
        arcs = core.step[core.tail] == i
        np.minimum.at(cost, core.head[arcs], cost[core.tail[arcs]] + core.cost[arcs])
    return cost[-1]


def _sequences(regions, moves, positions, x_step_m):
    """All sequences of regions that x can follow, with their costs; the goal is waited in, once reached."""
    onwards = {}
    for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True):
        onwards.setdefault(i, []).append(j)
    found = []

    def extend(sequence, cost, low, high):
        if len(sequence) == positions:
            if sequence[-1] == regions.goal:
                found.append((cost, sequence))
            return
        i = sequence[-1]
        paid = cost + (0.0 if i == regions.goal else regions.kappa[i])
        for j in [i, *(onwards.get(i, []) if i != regions.goal else [])]:
            least = max(low - x_step_m, regions.x_window_m[j, 0])
            largest = min(high + x_step_m, regions.x_window_m[j, 1])
            if least <= largest + 1e-9:
                extend([*sequence, j], paid, least, largest)

    extend([regions.start], 0.0, *regions.x_window_m[regions.start])
    return found


@settings(max_examples=60)
@given(st.integers(0, 1_000_000), st.floats(0.5, 4.0))
def test_every_route_of_at_most_t_is_in_the_core_whole(random_problem, core_of, seed, factor):
    """For random thresholds: each sequence that x can follow and that costs at most T has all its nodes and arcs."""
    regions, moves, _ = random_problem(seed)
    positions = 4
    bounds = shortest_paths(regions, moves, KappaSum())
    threshold = factor * (bounds.optimum if np.isfinite(bounds.optimum) else 20.0)
    core = core_of(regions, moves, bounds, threshold, positions, 1.0)
    nodes = set(zip(core.step.tolist(), core.region.tolist(), strict=True))
    arcs = {
        (core.step[t], core.region[t], core.region[h])
        for t, h in zip(core.tail.tolist(), core.head.tolist(), strict=True)
    }
    sequences = [(cost, sequence) for cost, sequence in _sequences(regions, moves, positions, 1.0) if cost <= threshold]
    for _, sequence in sequences:
        assert nodes.issuperset(enumerate(sequence))
        assert arcs.issuperset(zip(range(positions - 1), sequence, sequence[1:], strict=False))
    if sequences:
        assert core.bound <= min(cost for cost, _ in sequences) + 1e-9
        assert not core.empty


@settings(max_examples=100)
@given(st.integers(0, 1_000_000), st.floats(1.0, 4.0))
def test_a_core_starts_at_the_start_and_ends_at_the_goal(random_problem, core_of, seed, factor):
    """Its first node is the start at the first step, its last the goal at the last, or there is no core at all."""
    regions, moves, positions = random_problem(seed)
    bounds = shortest_paths(regions, moves, KappaSum())
    if not np.isfinite(bounds.optimum):
        return
    core = core_of(regions, moves, bounds, factor * bounds.optimum, positions, 1.0)
    if core.empty:
        assert len(core.step) == core.regions == 0
        return
    assert (core.step[0], core.region[0]) == (0, regions.start)
    assert (core.step[-1], core.region[-1]) == (positions - 1, regions.goal)
    assert core.bound <= core.threshold * (1.0 + 1e-8)
    # An arc leads one step on, costs kappa of the region left, and nothing at the goal.
    assert (core.step[core.head] == core.step[core.tail] + 1).all()
    left = core.region[core.tail]
    np.testing.assert_array_equal(core.cost, np.where(left == regions.goal, 0.0, regions.kappa[left]))
    # Windows only shrink.
    assert (core.window_m[:, 0] >= regions.x_window_m[core.region, 0] - 1e-12).all()
    assert (core.window_m[:, 1] <= regions.x_window_m[core.region, 1] + 1e-12).all()
    assert _cheapest_in(core, positions) <= core.threshold * (1.0 + 1e-8)


def test_dead_ends_that_only_look_alive_make_no_core(hand_table, hand_moves, core_of):
    """Hulls of x are relaxations: a node in the middle looks cheap and reachable, but never both at once.

    j is reached cheaply over h1 and, at the x from which the goal is in reach, only over a, a and h2: that costs 85.
    """
    h1, a, h2, j, start, goal = range(6)
    regions = hand_table(
        [(-4.0, -4.0), (-4.0, -2.0), (-1.0, -1.0), (-5.0, 0.0), (-4.0, -4.0), (1.0, 1.0)],
        [1.0, 12.0, 1.0, 50.0, 10.0, 2.0],
    )
    moves = hand_moves([(start, h1), (h1, j), (start, a), (a, h2), (h2, j), (j, goal)])
    bounds = shortest_paths(regions, moves, KappaSum())
    for threshold in (75.0, 84.9):
        core = core_of(regions, moves, bounds, threshold, 6, 1.0)
        assert core.empty
        assert len(core.step) == 0
    core = core_of(regions, moves, bounds, 85.0, 6, 1.0)
    assert core.region[0] == start
    assert core.bound == 85.0


def test_a_threshold_below_the_optimum_leaves_nothing(cross, core_of):
    """And the optimum itself leaves the routes that cost just that."""
    bounds = shortest_paths(cross.regions, cross.moves, KappaSum())
    below = core_of(cross.regions, cross.moves, bounds, bounds.optimum * 0.999, 25, 0.1)
    assert below.empty
    assert below.regions == 0
    exact = core_of(cross.regions, cross.moves, bounds, bounds.optimum, 25, 0.1)
    assert exact.regions <= 20
    assert exact.bound == pytest.approx(bounds.optimum)
    assert _cheapest_in(exact, 25) == pytest.approx(bounds.optimum)


def test_cores_grow_with_their_threshold(cross, core_of):
    """A larger T contains all of a smaller one."""
    bounds = shortest_paths(cross.regions, cross.moves, KappaSum())
    sizes = []
    for margin in (0.001, 0.02, 0.05):
        core = core_of(cross.regions, cross.moves, bounds, bounds.optimum * (1.0 + margin), 25, 0.1)
        sizes.append((core.regions, len(core.step), len(core.tail)))
    assert sizes == sorted(sizes)
    assert sizes[0] < sizes[1] < sizes[2]


def test_a_step_budget_too_small_leaves_nothing(cross, core_of):
    """Eleven moves are twelve positions: eleven do not do, whatever they may cost."""
    bounds = shortest_paths(cross.regions, cross.moves, KappaSum())
    short = core_of(cross.regions, cross.moves, bounds, bounds.optimum * 1.2, 11, 0.1)
    assert short.empty
    assert short.bound == np.inf
    assert not core_of(cross.regions, cross.moves, bounds, bounds.optimum * 1.2, 12, 0.1).empty


def test_waiting_gives_x_the_time_it_needs(hand_table, hand_moves, core_of):
    """From x 0 to x 3 at one a step: two moves are not enough, and waiting where kappa is least is cheapest."""
    regions = hand_table([(0.0, 3.0), (0.0, 0.0), (3.0, 3.0)], [2.0, 7.0, 1.0])
    moves = hand_moves([(1, 0), (0, 2)])
    bounds = shortest_paths(regions, moves, KappaSum())
    assert bounds.optimum == 9.0
    assert core_of(regions, moves, bounds, 9.0, 4, 1.0).empty
    core = core_of(regions, moves, bounds, 11.0, 4, 1.0)
    assert core.bound == 11.0
    arcs = {
        (int(core.step[t]), int(core.region[t]), int(core.region[h])) for t, h in zip(core.tail, core.head, strict=True)
    }
    assert arcs == {(0, 1, 0), (1, 0, 0), (2, 0, 2)}
    middle = core.region == 0
    np.testing.assert_allclose(core.window_m[middle], [[1.0, 1.0], [2.0, 2.0]])


def test_the_memory_of_a_core_is_counted_beforehand(quick, core_of):
    """It covers what building one takes up beside the moves themselves."""
    bounds = shortest_paths(quick.regions, quick.moves, KappaSum())
    moves = cheap_moves(quick.moves, bounds, 1.2 * bounds.optimum)
    tracemalloc.start()
    core_of(quick.regions, moves, bounds, 1.2 * bounds.optimum, 200, 0.1)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert core_bytes(bounds, 1.2 * bounds.optimum, 200) == pytest.approx(peak, rel=0.5)
