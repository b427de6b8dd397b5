"""The least largest kappa: no route has less, and among those that have it none costs less."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import InfeasibleError
from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route
from pipeline.route.bounds.bottleneck import moves_within
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import Moves
from pipeline.route.moves.rejections import Rejection
from pipeline.route.moves.screen import Screen
from pipeline.route.problem import RouteProblem
from pipeline.route.search.objective import find_best
from pipeline.route.search.states import unexpanded_graph

KAPPA = Rejection("kappa exceeds its cap", "route.kappa_max")


@settings(max_examples=80)
@given(st.integers(0, 1_000_000), st.sampled_from([0.0, 0.2, 0.4]))
def test_the_bottleneck_route_is_that_of_brute_force(
    random_problem, cheapest, quick_config, vary, machine, seed, share
):
    """With x binding and a share of the moves bad: the least cap by a dynamic program, and the least sum under it."""
    regions, moves, positions = random_problem(seed)
    random = np.random.default_rng(seed)
    bad = np.triu(random.random((len(regions), len(regions))) < share)
    bad |= bad.T
    good = ~bad[moves.source, moves.target]
    allowed = Moves(moves.source[good], moves.target[good])
    config = vary(
        quick_config, {"route.x_step_m": 1.0, "route.step_budget": positions, "route.objective": "bottleneck"}
    )
    expected = next(
        (
            (cap, cost)
            for cap in np.unique(regions.kappa)
            if cap >= max(regions.kappa[-2:])
            and np.isfinite(cost := cheapest(regions, moves_within(allowed, regions.kappa, cap), positions, 1.0))
        ),
        None,
    )
    screen = Screen(lambda source, target: [KAPPA if flawed else None for flawed in bad[source, target]], len(regions))
    bounds = shortest_paths(regions, moves, KappaSum())
    problem = RouteProblem.of(config, machine, regions, moves)
    best = find_best(problem, unexpanded_graph(regions, moves), bounds, screen)
    if expected is None:
        assert best is None
        return
    rows = best.sequence.region
    assert regions.kappa[rows].max() == best.cap == expected[0]
    assert best.objective == pytest.approx(expected[1], abs=1e-6)


def test_the_bottleneck_route_has_the_least_largest_kappa(quick_config, vary, quick, assert_rules):
    """It costs more in total and less at worst; with any lower cap on kappa there is no route."""
    config = vary(quick_config, {"route.objective": "bottleneck"})
    route = plan_route(config, quick.machine, quick.regions)
    plain = plan_route(quick.config, quick.machine, quick.regions)
    assert_rules(config, quick.machine, route)
    assert route.kappa_max < plain.kappa_max
    assert route.objective > plain.objective
    below = vary(quick_config, {"route.kappa_max": route.kappa_max - 1e-6})
    with pytest.raises(InfeasibleError, match="proven"):
        plan_route(below, quick.machine, build_regions(below, build_machine(below.machine)))
