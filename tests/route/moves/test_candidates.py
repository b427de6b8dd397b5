"""Moves between regions, and the cheap filters against tunnelling."""

import tracemalloc

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine.clearance import link_pairs
from pipeline.progress import Monitor, silent
from pipeline.route.bounds.shortest_paths import shortest_paths
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.memory import memory_gb
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import MoveSearch, find_moves, passing_codes, rule_moves
from pipeline.route.moves.check import check_moves
from pipeline.route.regions.build import build_regions


@pytest.fixture(scope="module")
def signed_distances(joints):
    """Give a function that solves p + s u + d n = r + t v for all pairs of links: signs of d where both are met."""

    def compute(machine, regions, slack=0.05):
        carts, platform, _ = joints(machine, regions.pose, regions.q_m)
        signs = []
        for a, b in link_pairs(machine):
            u, v = platform[:, a] - carts[:, a], platform[:, b] - carts[:, b]
            n = np.cross(u, v)
            parallel = np.linalg.norm(n, axis=1) < 1e-6 * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
            system = np.where(parallel[:, None, None], np.eye(3), np.stack([u, -v, n], axis=2))
            s, t, d = np.linalg.solve(system, (carts[:, b] - carts[:, a])[..., None])[..., 0].T
            met = (np.minimum(s, t) >= -slack) & (np.maximum(s, t) <= 1.0 + slack)
            signs.append(np.where(met & ~parallel, np.sign(d), 0.0))
        return np.stack(signs, axis=1)

    return compute


def _as_set(moves):
    return set(zip(moves.source.tolist(), moves.target.tolist(), strict=True))


def _brute_force(problem, signs):
    """All moves by comparing every region with every other, from the rules alone."""
    regions, steps = problem.regions, step_sizes(problem.config.route)
    letters = (regions.modes[:, None] & np.array([4, 2, 1])) > 0
    may_change = regions.gates[:, None] == np.array([1, 2, 3])
    found = set()
    for i in range(len(regions)):
        if i == regions.goal:
            continue
        apart = np.abs(regions.controlled[:, 1:] - regions.controlled[i, 1:])
        ok = (apart <= steps[1:] * (1.0 + 1e-9)).all(axis=1)
        ok &= ((letters == letters[i]) | may_change[i]).all(axis=1)
        ok &= regions.det_sign == regions.det_sign[i]
        ok &= (signs * signs[i] >= 0.0).all(axis=1)
        low = np.maximum(regions.x_window_m[:, 0], regions.x_window_m[i, 0] - steps[0])
        high = np.minimum(regions.x_window_m[:, 1], regions.x_window_m[i, 1] + steps[0])
        ok &= low <= high + 1e-9
        # Between gates of one arm the mode is kept: leaving the last of them can change it.
        ok &= (regions.gates == 0) | (regions.gates != regions.gates[i]) | (regions.modes == regions.modes[i])
        ok[[i, regions.start]] = False
        found |= {(i, j) for j in np.flatnonzero(ok).tolist()}
    return found


def test_moves_are_what_comparing_all_pairs_gives(small, signed_distances):
    """Every move of the rules is there, once, and no other."""
    assert set(small.regions.gates) == {0, 1, 2, 3}
    expected = _brute_force(small, signed_distances(small.machine, small.regions))
    assert len(expected) == len(small.moves) > 10_000
    assert _as_set(small.moves) == expected


def test_moves_mind_windows_of_x_when_rails_are_short(small_config, vary, pose_problem, signed_distances):
    """Where windows of x are far apart there is no move, although all else is near."""
    values = {f"machine.rails.{k}.travel_m": [0.0, 0.75] for k in range(3)}
    ends = {"task.goal.x_m": -0.4, "route.x_step_m": 0.02}
    problem = pose_problem(vary(small_config, values | ends))
    expected = _brute_force(problem, signed_distances(problem.machine, problem.regions))
    assert _as_set(problem.moves) == expected
    wide = find_moves(vary(small_config, values | ends | {"route.x_step_m": 1.0}), problem.machine, problem.regions)
    assert len(wide) > len(expected) > 1_000


def test_count_agrees_with_an_independent_implementation(cross):
    """0.1 m, 10 degrees: 1,870,653 moves, within half a percent.

    It has those between gates of one arm that change its mode, too: as many as keep it, and one from each gate to its
    twin in the other mode.
    """
    gates = cross.regions.gates
    between = (gates[cross.moves.source] > 0) & (gates[cross.moves.source] == gates[cross.moves.target])
    changing = np.count_nonzero(between) + np.count_nonzero(gates)
    assert changing > 100_000
    assert len(cross.moves) + changing == pytest.approx(1_870_653, rel=0.005)


def test_moves_are_sorted_by_their_source(cross):
    """That is what the graph's rows are read off."""
    assert (np.diff(cross.moves.source) >= 0).all()


def test_the_goal_is_never_left_and_the_start_never_entered(cross):
    """The goal absorbs; coming back to the start would only cost."""
    assert cross.regions.goal not in cross.moves.source
    assert cross.regions.start not in cross.moves.target
    assert cross.regions.start in cross.moves.source
    assert cross.regions.goal in cross.moves.target


def test_a_mode_changes_only_when_leaving_a_gate_of_that_arm(cross):
    """(38): if c_{i-1,k} = 0 then a_{i,k} = a_{i-1,k}."""
    regions, moves = cross.regions, cross.moves
    changed = regions.modes[moves.source] ^ regions.modes[moves.target]
    bit = np.array([0, 4, 2, 1])[regions.gates[moves.source]]
    assert set(np.unique(changed)) == {0, 1, 2, 4}
    assert ((changed == 0) | (changed == bit)).all()


def test_moves_that_keep_the_mode_go_both_ways(small):
    """Only a mode change has a direction: out of the gate."""
    regions = small.regions
    kept = {
        (i, j)
        for i, j in _as_set(small.moves)
        if regions.modes[i] == regions.modes[j] and regions.start not in (i, j) and regions.goal not in (i, j)
    }
    assert kept == {(j, i) for i, j in kept}


def test_the_graph_costs_what_its_source_costs(small):
    """An entry per move, holding kappa of the region left."""
    graph = small.moves.graph(small.regions.kappa[small.moves.source], len(small.regions)).tocoo()
    assert set(zip(graph.row.tolist(), graph.col.tolist(), strict=True)) == _as_set(small.moves)
    np.testing.assert_array_equal(graph.data, small.regions.kappa[graph.row])


def test_start_and_goal_alone_have_a_move_only_when_near(small):
    """A table without a grid: two regions one step apart or not."""
    ends = small.regions.take(slice(-2, None))
    config, machine = small.config, small.machine
    assert len(find_moves(config, machine, ends)) == 0
    near = ends.take(np.array([0, 0]))
    assert _as_set(find_moves(config, machine, near)) == {(0, 1)}


def test_codes_hold_the_signs_of_all_pairs_and_of_det_h(small, signed_distances):
    """Bits 0 to 15 for positive, 16 to 31 for negative signs, the determinant's last."""
    codes = passing_codes(small.machine, small.regions)
    # Ours points from one line to the other, the pipeline's the other way: only opposite signs count.
    signs = np.column_stack([-signed_distances(small.machine, small.regions), small.regions.det_sign])
    bits = np.arange(signs.shape[1])
    np.testing.assert_array_equal((codes[:, None] >> bits) & 1, signs > 0)
    np.testing.assert_array_equal((codes[:, None] >> (bits + 16)) & 1, signs < 0)


@pytest.fixture(scope="module")
def tunnels(cross):
    """Find the pairs of neighbouring regions that only the filters against tunnelling keep apart."""
    table = cross.regions.take(np.flatnonzero(cross.regions.gates == 0))
    admitted = find_moves(cross.config, cross.machine, table)
    steps = step_sizes(cross.config.route)
    neighbours = MoveSearch.of(table, steps, np.zeros(len(table), dtype=np.int64), steps[0]).collect(silent)
    codes = [moves.source.astype(np.int64) * len(table) + moves.target for moves in (neighbours, admitted)]
    pairs = np.column_stack(np.divmod(np.setdiff1d(*codes, assume_unique=True), len(table)))
    return table, pairs[(pairs < table.start).all(axis=1)]


def _check(problem, table, pairs):
    every = np.random.default_rng(1).permutation(len(pairs))[:150]
    picked = pairs[every]
    return check_moves(problem.config, problem.machine, table.pose[picked], table.q_m[picked])


def test_moves_between_opposite_signs_of_det_h_are_not_admitted(cross, tunnels):
    """The first kind of tunnelling: a singularity between two regions. Followed, none of them holds."""
    table, pairs = tunnels
    opposite = pairs[table.det_sign[pairs[:, 0]] != table.det_sign[pairs[:, 1]]]
    assert len(opposite) > 10
    assert not _check(cross, table, opposite).good.any()
    admitted = cross.moves
    assert (cross.regions.det_sign[admitted.source] == cross.regions.det_sign[admitted.target]).all()


def test_moves_on_which_links_pass_through_each_other_are_not_admitted(cross, tunnels, signed_distances):
    """The third kind of tunnelling: the links are apart at both ends, on opposite sides. Followed, they meet.

    Taken are moves whose closest points are well inside the links: the filter's slack also refuses some harmless ones.
    """
    table, pairs = tunnels
    # Links 2a-2b and 3a-3b are as good as parallel: their perpendicular turns over without the links coming close.
    signs = signed_distances(cross.machine, table, slack=-0.02)
    signs[:, [link_pairs(cross.machine).index(pair) for pair in ((1, 2), (3, 4), (4, 5))]] = 0.0
    passing = pairs[(signs[pairs[:, 0]] * signs[pairs[:, 1]] < 0.0).any(axis=1)]
    passing = passing[table.det_sign[passing[:, 0]] == table.det_sign[passing[:, 1]]]
    assert len(passing) > 10
    assert table.link_distance_m[passing].min() >= cross.machine.link_link_m
    checks = _check(cross, table, passing)
    assert not checks.good.any()
    assert "links come too close" in map(str, checks.rejections)


def test_progress_ends_near_one(small):
    """All neighbours are gone through, and someone who waits sees it."""
    seen = []
    find_moves(
        small.config, small.machine, small.regions, Monitor(lambda message, fraction=None: seen.append(fraction))
    )
    assert seen == sorted(seen)
    assert 0.9 < seen[-1] <= 1.0


def test_the_number_of_moves_is_known_beforehand(small, quick):
    """Exact if all origins are counted, within some percent from a sample."""
    for problem, tolerance in ((small, 0.0), (quick, 0.03)):
        steps, codes = step_sizes(problem.config.route), passing_codes(problem.machine, problem.regions)
        search = MoveSearch.of(problem.regions, steps, codes, steps[0])
        assert search.expected_moves(sample=2_000) == pytest.approx(len(problem.moves), rel=tolerance)


def test_moves_that_would_not_fit_are_refused_before_they_are_made(quick, vary):
    """The message names the estimate, the key and the grid; nothing as large as the moves was allocated."""
    config = vary(quick.config, {"route.memory_gb": 0.01})
    passing_codes(quick.machine, quick.regions)
    tracemalloc.start()
    with pytest.raises(NoSolutionError, match=r"GB of memory; route\.memory_gb allows 0\.01") as caught:
        find_moves(config, quick.machine, quick.regions)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert caught.value.stage == "route"
    assert "coarsen route.grid" in caught.value.advice
    assert caught.value.diagnosis["expected_moves"] == pytest.approx(len(quick.moves), rel=0.05)
    assert peak < 40e6


def test_the_estimate_of_memory_is_an_upper_bound_not_far_off(quick):
    """Beside what the interpreter saw allocated for the table, the moves and the shortest paths."""
    tracemalloc.start()
    regions = build_regions(quick.config, quick.machine)
    moves = find_moves(quick.config, quick.machine, regions)
    shortest_paths(regions, moves, KappaSum())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    estimate = memory_gb(len(regions), len(moves)) * 1e9
    assert peak <= estimate <= 2.0 * peak


def test_the_rules_alone_admit_more(small):
    """All admitted moves are among them, and many more: whatever x, det H and the links do."""
    by_rule = _as_set(rule_moves(small.config, small.regions))
    assert _as_set(small.moves) < by_rule
    steps, regions = step_sizes(small.config.route), small.regions
    source, target = np.array(sorted(by_rule)).T
    apart = np.abs(regions.controlled[source, 1:] - regions.controlled[target, 1:])
    assert (apart <= steps[1:] * (1.0 + 1e-9)).all()
    assert (regions.det_sign[source] != regions.det_sign[target]).any()
