"""Itineraries: routes of the expanded graph are those routes of the regions that have done everything asked."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import NoSolutionError
from pipeline.route import plan_route
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves
from pipeline.route.planner import plan_routes
from pipeline.route.search.states import expand_states, near_route, unexpanded_graph


def _walks(regions, moves, length):
    """All sequences from start to goal of exactly so many regions, as tuples of rows."""
    onwards = {}
    for i, j in zip(moves.source.tolist(), moves.target.tolist(), strict=True):
        onwards.setdefault(i, []).append(j)
    walks = [(regions.start,)]
    for _ in range(length - 1):
        walks = [(*walk, j) for walk in walks for j in onwards.get(walk[-1], [])]
    return {walk for walk in walks if walk[-1] == regions.goal}


@settings(max_examples=100)
@given(st.integers(0, 1_000_000), st.integers(0, 2), st.integers(0, 2))
def test_walks_of_the_graph_are_those_that_have_done_everything_asked(random_problem, seed, visits, routes):
    """By brute force: each such walk of the regions is there once, and no other."""
    regions, moves, _ = random_problem(seed)
    random = np.random.default_rng(seed)
    visit = np.zeros(len(regions), dtype=np.int64)
    visit[:-2] = random.integers(0, visits + 1, len(regions) - 2)
    visits = int(visit.max())
    regions = replace(regions, visits=visit)
    near = random.random((routes, len(regions))) < 0.6
    near[:, -2:] = True
    graph = expand_states(regions, moves, near)
    assert (graph.base[-2], graph.base[-1]) == (regions.start, regions.goal)
    assert (np.diff(graph.moves.source) >= 0).all()
    for length in (2, 3, 4, 5):
        wanted = set()
        for walk in _walks(regions, moves, length):
            stops = iter(visit[list(walk)].tolist())
            if all(k in stops for k in range(1, visits + 1)) and (~near[:, list(walk)]).any(axis=1).all():
                wanted.add(walk)
        found = [tuple(graph.base[list(walk)].tolist()) for walk in _walks(graph.regions, graph.moves, length)]
        assert len(found) == len(set(found))
        assert set(found) == wanted


def test_many_better_routes_take_no_memory_to_speak_of(hand_table):
    """Regions near none of them, which most are, have one row: there is never a table of states by regions."""
    n = 5_000
    random = np.random.default_rng(0)
    regions = hand_table([(0.0, 1.0)] * n, [2.0] * n)
    near = random.random((9, n)) < 0.02
    near[:, -2:] = True
    moves = Moves(np.sort(random.integers(0, n, 50_000)), random.integers(0, n, 50_000))
    tracemalloc.start()
    graph = expand_states(regions, moves, near)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert n < len(graph.base) < 1.5 * n
    assert peak < 10_000_000


def test_nothing_asked_leaves_everything_as_it_is(quick):
    """No copies, no work."""
    graph = expand_states(quick.regions, quick.moves, np.zeros((0, len(quick.regions)), dtype=bool))
    assert graph.regions is quick.regions
    assert graph.moves is quick.moves
    assert len(unexpanded_graph(quick.regions, quick.moves).base) == len(quick.regions)


def test_near_means_within_the_distance_and_in_the_same_mode(quick):
    """But for gates, where both modes of the arm are the same place."""
    steps = step_sizes(quick.config.route)
    row = int(np.flatnonzero(quick.regions.gates == 1)[0])
    near = np.flatnonzero(near_route(quick.regions, steps, np.array([row]), 1.0))
    apart = np.abs(quick.regions.controlled[near, 1:] - quick.regions.controlled[row, 1:]) / steps[1:]
    assert apart.max() <= 1.0 + 1e-6
    modes = set((quick.regions.modes[near] ^ quick.regions.modes[row]).tolist())
    assert 4 in modes
    assert near_route(quick.regions, steps, np.array([row]), 0.0)[row]


@pytest.fixture(scope="module")
def three(quick, vary):
    """Find the three best routes of the quick task."""
    config = vary(quick.config, {"route.alternative_distance": 2})
    return config, plan_routes(config, quick.machine, quick.regions, 3)


def test_alternatives_stray_from_all_better_routes(three, quick, assert_rules):
    """Each costs no less than the one before, keeps all rules, and is somewhere far from every better one."""
    config, routes = three
    assert len(routes) == 3
    assert [route.objective for route in routes] == sorted(route.objective for route in routes)
    steps = step_sizes(config.route)
    for rank, route in enumerate(routes):
        assert_rules(config, quick.machine, route)
        assert route.search.gap == 0.0
        for better in routes[:rank]:
            assert not near_route(quick.regions, steps, better.region, 2.0)[route.region].all()


def test_an_alternative_is_planned_by_its_rank(three, quick, vary):
    """`route.alternative` picks one of them."""
    config, routes = three
    second = plan_route(vary(config, {"route.alternative": 2}), quick.machine, quick.regions)
    np.testing.assert_array_equal(second.region, routes[1].region)


def test_a_graph_that_would_not_fit_is_refused(quick, vary):
    """Every visit repeats all regions and moves; the message says so, with the keys."""
    visits = np.zeros(len(quick.regions), dtype=np.int64)
    visits[:9] = np.arange(1, 10)
    regions, options = replace(quick.regions, visits=visits), vary(quick.config, {"route.memory_gb": 0.3}).route
    with pytest.raises(NoSolutionError, match=r"repeated for visits made .* route\.memory_gb allows 0\.3") as caught:
        expand_states(regions, quick.moves, np.zeros((0, len(regions)), dtype=bool), options)
    assert "task.visit" in caught.value.advice
