"""Routes between all pairs: each as good as the one that is planned by itself."""

import numpy as np
import pytest

from pipeline.atlas import AtlasEntry, AtlasGraph, atlas_stations, build_graph
from pipeline.atlas.plan import IMPOSSIBLE, Pair
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.machine import build_machine
from pipeline.route import build_regions, grid_regions, plan_route
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.moves.candidates import find_moves
from pipeline.route.regions.counting import require_possible_task
from pipeline.status import Status


def assert_as_alone(graph: AtlasGraph, entries: dict[Pair, AtlasEntry], grid=None) -> int:
    """Compare every entry with a route planned by itself; return how many have one."""
    found = 0
    for pair, entry in entries.items():
        config = graph.pair_config(pair)
        try:
            require_possible_task(config, graph.machine)
            regions = build_regions(config, graph.machine, grid=grid)
            alone = plan_route(config, graph.machine, regions)
        except (ConfigError, NoSolutionError) as error:
            assert entry.route is None
            assert isinstance(error, ConfigError) == (entry.status == IMPOSSIBLE)
        else:
            found += 1
            assert entry.status == Status.OPTIMAL
            assert entry.route is not None
            assert entry.route.objective == pytest.approx(alone.objective, rel=2e-6, abs=1e-9)
            assert entry.route.search.bound <= alone.objective * (1.0 + 1e-6) + 1e-9
            assert len(entry.route) <= config.route.step_budget
    return found


@pytest.mark.parametrize(
    ("seed", "objective", "count", "apart_m"),
    [
        (1, "sum", 3, 0.1),
        (2, "integral", 2, 0.0),
        (1, "integral", 2, 0.05),
        (1, "time", 2, 0.0),
        (2, "bottleneck", 2, 0.1),
    ],
)
def test_every_route_is_as_good_as_the_one_planned_alone(
    seed: int, objective: str, count: int, apart_m: float, with_stations, plan_all, small_grid, assert_rules
) -> None:
    """Shared moves, screens and shortest paths, and reversal, change no optimum and break no rule."""
    config = with_stations(seed, count, {"route.objective": objective}, off_grid_m=0.04, apart_m=apart_m)
    graph, entries = plan_all(config)
    assert assert_as_alone(graph, entries, small_grid) >= 2
    for pair, entry in entries.items():
        assert entry.from_reverse == (pair[0] > pair[1])
        if entry.route is not None:
            assert_rules(graph.pair_config(pair), graph.machine, entry.route)


def test_where_the_direction_counts_both_are_searched(with_stations, plan_all, small_config, vary) -> None:
    """Dry friction helps to hold and hinders motion: nothing is taken from the opposite pair."""
    limits = {"machine.limits.telescopes.force_n": 300.0, "machine.dynamics.friction.telescopes_n": 20.0}
    config = with_stations(3, changes=limits)
    machine = build_machine(config.machine)
    grid = grid_regions(config, machine)
    graph, entries = plan_all(config, machine, grid)
    assert not any(entry.from_reverse for entry in entries.values())
    assert_as_alone(graph, entries, grid)


def test_straight_ends_and_boxes_to_avoid_count(with_stations, plan_all, small_grid) -> None:
    """Every station is left and reached along the straight ends, so that the way back is another route."""
    config = with_stations(
        1,
        changes={
            "refine.approach_m": 0.05,
            "refine.start_direction": [0.0, 0.0, 1.0],
            "refine.goal_direction": [0.0, 1.0, 0.0],
            "task.avoid": [{"y_m": [0.62, 0.66], "z_m": [0.62, 0.66], "rx_deg": [-1.0, 1.0]}],
        },
    )
    graph, entries = plan_all(config)
    assert not any(entry.from_reverse for entry in entries.values())
    assert_as_alone(graph, entries, small_grid)


def test_budgets_and_alternatives_count(with_stations, plan_all, small_grid) -> None:
    """Both are those of a route planned alone."""
    changes = {"task.budget.mode_changes": 3, "route.alternative": 2, "route.alternative_distance": 1.0}
    graph, entries = plan_all(with_stations(2, count=2, changes=changes))
    assert_as_alone(graph, entries, small_grid)


def test_no_detour_over_a_station_is_better(with_stations, plan_all) -> None:
    """Stations on the grid: from a to c costs no more than from a to b and from b to c, if positions are plenty."""
    _, entries = plan_all(with_stations(5, count=4, changes={"route.objective": "integral", "route.step_budget": 60}))
    costs = {pair: entry.route.objective for pair, entry in entries.items() if entry.route is not None}
    detours = [(a, b, c) for a, c in costs for b in range(4) if (a, b) in costs and (b, c) in costs]
    assert len(detours) >= 12
    for a, b, c in detours:
        assert costs[a, c] <= (costs[a, b] + costs[b, c]) * (1.0 + 1e-6)


def test_opposite_signs_of_det_h_are_impossible_both_ways(small_config, small_grid, plan_all, vary) -> None:
    """The reason is given, in the words of each direction, and nothing is searched."""
    config = vary(small_config, {"atlas.stations": []})
    machine = build_machine(config.machine)
    wrong = np.flatnonzero((small_grid.det_sign < 0.0) & (small_grid.gates == 0))[0]
    x, y, z, rx, rz = small_grid.controlled[wrong].tolist()
    x = float(small_grid.x_window_m[wrong].mean())
    mode = [f"{a}{b}{c}" for a in "LR" for b in "LR" for c in "LR"][small_grid.modes[wrong]]
    goal = {"x_m": x, "y_m": y, "z_m": z, "rx_deg": np.rad2deg(rx), "rz_deg": np.rad2deg(rz), "mode": mode}
    _, entries = plan_all(vary(config, {"task.goal": goal}), machine)
    assert {entry.status for entry in entries.values()} == {IMPOSSIBLE}
    assert all("det H" in entry.reason for entry in entries.values())


def test_a_search_without_time_says_so(with_stations, plan_all) -> None:
    """A pair that ran out of time is neither a route nor a proof."""
    _, entries = plan_all(with_stations(1, count=2, changes={"route.time_limit_s": 1e-9}))
    assert {entry.status for entry in entries.values()} == {Status.TIME_LIMIT}
    assert all(entry.advice.startswith("raise route.time_limit_s") for entry in entries.values())


def test_the_shortest_paths_are_those_of_the_pair(with_stations, small_grid) -> None:
    """F and B over all stations at a time, restricted to a pair, are those over its own moves."""
    config = with_stations(4, off_grid_m=0.03)
    graph = build_graph(config, build_machine(config.machine), atlas_stations(config), small_grid)
    problem = graph.problem((0, 2))
    own = find_moves(problem.config, problem.machine, problem.regions)
    assert set(zip(own.source.tolist(), own.target.tolist(), strict=True)) == set(
        zip(problem.moves.source.tolist(), problem.moves.target.tolist(), strict=True)
    )
    assert (np.diff(problem.moves.source) >= 0).all()
    alone = shortest_paths(problem.regions, own, problem.cost)
    np.testing.assert_allclose(problem.shortest.forward, alone.forward)
    np.testing.assert_allclose(problem.shortest.backward, alone.backward)


def test_what_guides_stage_two_is_found_on_request(with_stations, plan_all) -> None:
    """Without it searches are shorter; the routes are the same."""
    config = with_stations(6, count=2)
    _, guided = plan_all(config)
    _, other = plan_all(config, guided=False)
    assert np.isfinite(guided[0, 1].route.search.least_kappa_max)
    assert np.isinf(other[0, 1].route.search.least_kappa_max)
    np.testing.assert_array_equal(guided[0, 1].route.region, other[0, 1].route.region)
