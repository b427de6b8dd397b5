"""Moves followed continuously: every kind of flaw, and good moves."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.errors import NoSolutionError
from pipeline.machine import (
    MODES,
    condition_number,
    forward_kinematics,
    inverse_kinematics,
    min_distances,
    statics_matrix,
)
from pipeline.machine.clearance import link_pairs
from pipeline.machine.kinematics import follow, newton
from pipeline.route.bounds.shortest_paths import shortest_paths, shortest_route
from pipeline.route.cost.kappa_sum import KappaSum
from pipeline.route.moves.candidates import passing_codes, rule_moves
from pipeline.route.moves.check import check_moves, check_pairs
from pipeline.route.moves.rejections import NO_CLOSURE, SIGN_CHANGE, WRONG_BRANCH, Rejection
from pipeline.route.planner import plan_route

KAPPA = Rejection("kappa exceeds its cap", "route.kappa_max")
LINKS = Rejection("links come too close")
RAILS = Rejection("a link comes too close to a rail")
TILT = Rejection("the platform tilts too far", "task.tilt_max_deg")


def _ends(machine, first, second, modes=("LLL", "LLL")):
    """Poses (1, 2, 6) and actuators (1, 2, 5) of a move between two controlled poses."""
    solution = inverse_kinematics(machine, np.array([first, second]), np.array([MODES.index(mode) for mode in modes]))
    assert solution.reachable.all()
    return solution.pose[None], solution.q_m[None]


def _lenient(config, vary, **more):
    """Let nothing but what the test is about be a flaw."""
    values = {"task.tilt_max_deg": 85, "route.kappa_max": 1e9, "machine.clearance.link_link_m": 0.0}
    return vary(config, values | more)


@pytest.fixture(scope="module")
def sample(cross):
    """Draw two hundred admitted moves of the cross-check, and check them."""
    regions, moves = cross.regions, cross.moves
    inner = np.flatnonzero((moves.source < regions.start) & (moves.target < regions.start))
    picked = np.random.default_rng(7).choice(inner, 200, replace=False)
    rows = np.column_stack([moves.source[picked], moves.target[picked]])
    pose, q = regions.pose[rows], regions.q_m[rows]
    return pose, q, check_moves(cross.config, cross.machine, pose, q)


def test_most_admitted_moves_are_good(cross, sample):
    """The cheap filters leave little to forbid, and good moves keep the cap all the way."""
    _, _, checks = sample
    assert 0.9 < checks.good.mean() < 1.0
    assert checks.good.tolist() == [flaw is None for flaw in checks.rejections]
    assert (checks.kappa_max[checks.good] <= cross.config.route.kappa_max).all()


def test_a_move_is_as_good_the_other_way(cross, sample):
    """Both follow the same line of actuator positions: that is why a flaw forbids both directions."""
    pose, q, checks = sample
    back = check_moves(cross.config, cross.machine, pose[:, ::-1], q[:, ::-1])
    np.testing.assert_array_equal(back.good, checks.good)
    np.testing.assert_allclose(back.kappa_max[checks.good], checks.kappa_max[checks.good], rtol=1e-6)
    lost = {NO_CLOSURE, WRONG_BRANCH}
    same = [a == b for a, b in zip(checks.rejections, back.rejections, strict=True) if not {a, b} & lost]
    assert all(same)


def test_x_makes_no_difference_to_a_move(cross, sample):
    """Moving along X on the way shifts all carts alike: a flaw found at one x holds at any."""
    pose, q, checks = sample
    shifted_pose, shifted_q = pose[:40].copy(), q[:40].copy()
    for end, x in ((0, 0.3), (1, -0.5)):
        shifted_pose[:, end, 0] += x
        shifted_q[:, end, :3] += x
    shifted = check_moves(cross.config, cross.machine, shifted_pose, shifted_q)
    assert shifted.rejections == checks.rejections[:40]
    np.testing.assert_allclose(shifted.kappa_max, checks.kappa_max[:40], rtol=1e-6)


def test_kappa_max_is_nearly_that_of_poses_found_one_by_one(cross, sample, statics):
    """The largest kappa along a good move, against forward kinematics from the pose's neighbour: never more."""
    pose, q, checks = sample
    for row in np.flatnonzero(checks.good)[:3]:
        here, kappas = pose[row, :1], []
        for part in np.linspace(0.0, 1.0, 65):
            along = (1.0 - part) * q[row, :1] + part * q[row, 1:]
            here = forward_kinematics(cross.machine, along, here)
            kappas.append(np.linalg.cond(statics(cross.machine, here, along)[0], 2))
        assert 0.98 * max(kappas) <= checks.kappa_max[row] <= (1.0 + 1e-6) * max(kappas)


def test_a_move_that_leads_nowhere_is_good(cross):
    """Between a region and itself, or the two modes of a gate, nothing moves and nothing can fail."""
    regions = cross.regions
    rows = np.array([100, np.flatnonzero(regions.gates)[0]])
    pose, q = (np.repeat(column[rows][:, None], 2, axis=1) for column in (regions.pose, regions.q_m))
    checks = check_moves(cross.config, cross.machine, pose, q)
    assert checks.good.all()
    np.testing.assert_allclose(checks.kappa_max, regions.kappa[rows])


def test_pairs_of_rows_are_followed_at_one_x(quick):
    """Start and goal have their own x, other rows none: pairs are checked as if all had the same."""
    regions, moves = quick.regions, quick.moves
    at_ends = (moves.source == regions.start) | (moves.target == regions.goal)
    picked = np.concatenate([np.flatnonzero(at_ends)[::3], np.arange(0, len(moves), len(moves) // 100)])
    source, target = moves.source[picked], moves.target[picked]
    rows = np.column_stack([source, target])
    pose, q = regions.pose[rows], regions.q_m[rows]
    q[..., :3] += 0.4 - pose[..., :1]
    pose[..., 0] = 0.4
    expected = check_moves(quick.config, quick.machine, pose, q)
    checks = check_pairs(quick.config, quick.machine, regions, source, target)
    assert checks.rejections == expected.rejections
    np.testing.assert_allclose(checks.kappa_max, expected.kappa_max, rtol=1e-9)


def test_pairs_may_come_in_any_order_more_than_once_and_both_ways(quick):
    """Each move gets its own verdict back, however the work is cut into blocks."""
    regions, moves = quick.regions, quick.moves
    picked = np.random.default_rng(2).choice(len(moves), 60)
    source, target = moves.source[picked], moves.target[picked]
    once = check_pairs(quick.config, quick.machine, regions, source, target)
    order = np.random.default_rng(3).permutation(120) % 60
    swapped = np.arange(120) % 3 == 0
    first, second = np.where(swapped, target[order], source[order]), np.where(swapped, source[order], target[order])
    again = check_pairs(quick.config, quick.machine, regions, first, second, block=7)
    assert again.rejections == [once.rejections[k] for k in order]
    np.testing.assert_allclose(again.kappa_max, once.kappa_max[order], rtol=1e-9)


def test_no_moves_have_no_flaws(quick):
    """An empty question has an empty answer."""
    none = np.empty(0, dtype=np.int64)
    checks = check_pairs(quick.config, quick.machine, quick.regions, none, none)
    assert checks.rejections == []
    assert checks.kappa_max.shape == checks.good.shape == (0,)


def test_moves_out_of_gates_hold_in_either_mode(cross):
    """A move that begins at a serial singularity, where closure is regular, is good as often as any other."""
    regions, moves = cross.regions, cross.moves
    changing = (regions.gates[moves.source] > 0) & (regions.modes[moves.source] != regions.modes[moves.target])
    rows = np.flatnonzero(changing)[::400]
    checks = check_pairs(cross.config, cross.machine, regions, moves.source[rows], moves.target[rows])
    assert set(regions.gates[moves.source[rows]].tolist()) == {1, 2, 3}
    assert checks.good.mean() > 0.95


def test_links_passing_through_each_other_within_one_step_are_seen_when_followed(cross, vary):
    """The third kind of tunnelling, without its filter: the signed distance of two links changes its sign."""
    regions = cross.regions
    moves = rule_moves(cross.config, regions)
    codes = passing_codes(cross.machine, regions)
    links = (1 << len(link_pairs(cross.machine))) - 1
    positive, negative = codes & links, (codes >> 16) & links
    same_sign = regions.det_sign[moves.source] == regions.det_sign[moves.target]
    passing = (positive[moves.source] & negative[moves.target]) != 0
    rows = np.flatnonzero(passing & same_sign)
    rows = rows[:: len(rows) // 60]
    assert len(rows) > 20
    config = vary(cross.config, {"task.tilt_max_deg": 85, "route.kappa_max": 1e6})
    checks = check_pairs(config, cross.machine, regions, moves.source[rows], moves.target[rows])
    assert LINKS in checks.rejections
    # The rest passes beyond an end of one of the two: the filter's slack.
    rest = np.column_stack([moves.source, moves.target])[rows[checks.good]]
    poses, line = _along(cross.machine, regions.pose[rest], regions.q_m[rest], 300)
    distances, _ = min_distances(cross.machine, poses.reshape(-1, 6), line.reshape(-1, 5)[:, :3])
    assert distances.min() >= 0.03 - 1e-9


def test_losing_the_solution_is_a_flaw(machine, agder_config, vary):
    """Actuators that no platform can close on: the links tear apart before the second end."""
    config = _lenient(agder_config, vary)
    pose, q = _ends(machine, [1.0, 0.3, 0.9, 0, 0], [1.0, 0.3, 0.9, 0, 0])
    q[0, 1, 4] += 0.9
    checks = check_moves(config, machine, pose, q)
    assert checks.rejections == [NO_CLOSURE]
    assert not checks.good.any()


def test_ending_in_another_assembly_is_a_flaw(machine, agder_config, vary):
    """The actuators do not move at all, but the pose they are said to hold is another solution of the links."""
    config = _lenient(agder_config, vary)
    pose, q = _ends(machine, [1.0, 0.3, 0.9, 0, 0], [1.0, 0.3, 0.9, 0, 0])
    guesses = pose[0, 0] + np.random.default_rng(3).uniform(-1.0, 1.0, (100, 6))
    others, misses = newton(machine, np.repeat(q[0, :1], 100, axis=0), guesses)
    others = others[(misses < 1e-10) & (np.abs(others - pose[0, 0])[:, :3].max(axis=1) > 0.1)]
    assert len(others) > 0
    pose[0, 1] = others[0]
    assert check_moves(config, machine, pose, q).rejections == [WRONG_BRANCH]


def test_a_singularity_is_a_flaw(machine, agder_config, vary, statics):
    """Without tilt the platform can stay on its way through a singularity: det H has other signs at both ends."""
    config = _lenient(agder_config, vary)
    cases = [("LRL", 0.9, 0.075), ("LRL", 0.8, 0.525), ("LRL", 0.875, 0.2), ("RRL", 0.85, 0.3), ("RLR", 0.8, 0.2)]
    pairs = [_ends(machine, [1.0, y, z, 0, 0], [1.0, y + 0.025, z, 0, 0], (mode, mode)) for mode, z, y in cases]
    pose, q = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    signs = np.sign(np.linalg.det(statics(machine, pose.reshape(-1, 6), q.reshape(-1, 5)))).reshape(-1, 2)
    assert (signs[:, 0] != signs[:, 1]).all()
    flaws = check_moves(config, machine, pose, q).rejections
    # At such a point solutions branch off: rounding may lead onto another one.
    assert set(flaws) <= {SIGN_CHANGE, WRONG_BRANCH}
    assert SIGN_CHANGE in flaws


def _along(machine, pose, q, samples=64):
    """Poses and actuators along moves, shapes (n, samples + 1, 6) and (n, samples + 1, 5)."""
    part = np.linspace(0.0, 1.0, samples + 1)[:, None]
    line = q[:, :1] * (1.0 - part) + q[:, 1:] * part
    return follow(machine, line, pose[:, 0])[0], line


def test_kappa_beyond_its_cap_between_the_ends_is_a_flaw(cross, sample, vary):
    """A cap between the largest kappa of both ends and that on the way is only found by following."""
    pose, q, checks = sample
    pose, q, good = pose[:80], q[:80], checks.good[:80]
    poses, line = _along(cross.machine, pose, q, 300)
    kappa = condition_number(statics_matrix(cross.machine, poses, line[..., :3]))
    largest = kappa.max(axis=1)
    bulge = np.where(good, largest / kappa[:, [0, -1]].max(axis=1), 0.0)
    row = int(np.argmax(bulge))
    assert bulge[row] > 1.005
    move = slice(row, row + 1)
    for cap, flaw in ((0.9999 * largest[row], KAPPA), (1.0001 * largest[row], None)):
        config = vary(cross.config, {"route.kappa_max": cap})
        assert check_moves(config, cross.machine, pose[move], q[move]).rejections == [flaw]


@pytest.mark.parametrize(("limit", "flaw", "column"), [("link_link_m", LINKS, 0), ("link_rail_m", RAILS, 1)])
def test_links_too_close_between_the_ends_are_a_flaw(cross, sample, limit, flaw, column):
    """The same for the distance of links from each other and from rails."""
    pose, q, checks = sample
    good = np.flatnonzero(checks.good)[:50]
    poses, line = _along(cross.machine, pose[good], q[good], 300)
    distances = min_distances(cross.machine, poses.reshape(-1, 6), line.reshape(-1, 5)[:, :3])[column]
    distances = distances.reshape(len(good), -1)
    dip = distances[:, [0, -1]].min(axis=1) - distances.min(axis=1)
    row = int(np.argmax(dip))
    assert dip[row] > 1e-5
    move, least = good[[row]], distances[row].min()
    for asked, expected in ((least + 1e-6, flaw), (least - 1e-6, None)):
        machine = replace(cross.machine, **{limit: asked})
        assert check_moves(cross.config, machine, pose[move], q[move]).rejections == [expected]


def test_tilt_beyond_the_limit_is_a_flaw_but_for_the_accepted_overshoot(cross, vary):
    """Between two regions at 30 degrees the straight line in actuator space tilts a little farther."""
    regions, moves = cross.regions, cross.moves
    at_limit = np.isclose(np.rad2deg(regions.controlled[:, 3]), 30.0)
    both = np.flatnonzero(at_limit[moves.source] & at_limit[moves.target])[::4000]
    rows = np.column_stack([moves.source[both], moves.target[both]])
    pose, q = regions.pose[rows], regions.q_m[rows]
    poses, _ = _along(cross.machine, pose, q)
    tilt = np.rad2deg(np.abs(poses[:, :, [3, 5]]).max(axis=(1, 2)))
    counts = []
    for overshoot in (0.0, 0.5, 1.0, 10.0):
        config = vary(cross.config, {"route.follow.tilt_overshoot_deg": overshoot})
        flaws = check_moves(config, cross.machine, pose, q).rejections
        assert all(tilt[k] > 30.0 + overshoot for k, flaw in enumerate(flaws) if flaw == TILT)
        assert all(tilt[k] <= 30.0 + overshoot + 1e-9 for k, flaw in enumerate(flaws) if flaw is None)
        counts.append(flaws.count(TILT))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[2]
    assert counts[-1] == 0


def test_the_first_reason_is_the_one_told(cross, sample, vary):
    """Of kappa and tilt it is kappa, the more serious one."""
    pose, q, checks = sample
    good = np.flatnonzero(checks.good)
    tilted = good[np.abs(pose[good][:, :, [3, 5]]).max(axis=(1, 2)) > 0.1][:1]
    tight = vary(cross.config, {"route.kappa_max": 2, "task.tilt_max_deg": 1})
    assert check_moves(tight, cross.machine, pose[tilted], q[tilted]).rejections == [KAPPA]
    tight = vary(cross.config, {"task.tilt_max_deg": 1})
    assert check_moves(tight, cross.machine, pose[tilted], q[tilted]).rejections == [TILT]


def test_arm_3_changes_its_mode_at_its_gates_off_the_axis_too(small_config, vary, pose_problem):
    """With a_3a off the platform's y axis D_3 is coupled with ry, yet nearly all moves out of its gates hold."""
    values = {"machine.links.l3a.platform_point_m": [0.02, 0.10, 0.01], "task.locked_axes": ["rz"]}
    problem = pose_problem(vary(small_config, values))
    regions, moves = problem.regions, problem.moves
    changes = (regions.gates[moves.source] == 3) & (regions.modes[moves.source] ^ regions.modes[moves.target] == 1)
    rows = np.flatnonzero(changes)[::3]
    ends = np.column_stack([moves.source[rows], moves.target[rows]])
    assert len(ends) > 50
    checks = check_moves(problem.config, problem.machine, regions.pose[ends], regions.q_m[ends])
    assert checks.good.mean() > 0.9


@pytest.fixture(scope="module")
def without_tilt(cross_config, vary, pose_problem):
    """Make the 3-DOF machine with a lax cap of kappa: the route over its moves jumps over singularities."""
    return pose_problem(vary(cross_config, {"task.locked_axes": ["rx", "rz"], "route.kappa_max": 1000}))


def test_two_singularities_within_one_step_are_seen_when_followed(without_tilt, statics):
    """The second kind of tunnelling: det H has the same sign at both ends of a move and changes it twice between."""
    regions, machine = without_tilt.regions, without_tilt.machine
    rows = shortest_route(
        regions, without_tilt.moves, KappaSum(), shortest_paths(regions, without_tilt.moves, KappaSum())
    )
    ends = np.column_stack([rows[:-1], rows[1:]])
    checks = check_moves(without_tilt.config, machine, regions.pose[ends], regions.q_m[ends])
    assert not checks.good.all()
    row = int(np.flatnonzero(~checks.good)[0])
    assert checks.rejections[row] in (SIGN_CHANGE, WRONG_BRANCH, KAPPA)
    assert checks.kappa_max[row] > 1000.0
    first, second = ends[row]
    assert regions.det_sign[first] == regions.det_sign[second]
    assert regions.modes[first] == regions.modes[second]
    part = np.linspace(0.0, 1.0, 201)[:, None]
    between = regions.controlled[first] * (1.0 - part) + regions.controlled[second] * part
    solution = inverse_kinematics(machine, between, np.full(201, regions.modes[first]))
    signs = np.sign(np.linalg.det(statics(machine, solution.pose, solution.q_m)))
    assert np.count_nonzero(np.diff(signs)) == 2


def test_two_singularities_within_one_step_make_no_route(without_tilt, vary):
    """Once such moves are forbidden nothing is left: the 3-DOF machine has no route, however lax the cap."""
    config = vary(without_tilt.config, {"route.kappa_max": 200})
    kept = without_tilt.regions.kappa < 200
    assert np.isfinite(shortest_paths(without_tilt.regions, without_tilt.moves, KappaSum()).optimum)
    with pytest.raises(NoSolutionError, match="moves were forbidden that fail when followed") as caught:
        plan_route(config, without_tilt.machine, without_tilt.regions.take(kept))
    assert caught.value.diagnosis["status"] == "infeasible"
    assert "proven" in caught.value.reason
