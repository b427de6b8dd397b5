"""The region table."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.machine import build_machine, condition_number, inverse_kinematics, min_distances, statics_matrix
from pipeline.progress import Monitor
from pipeline.route import build_regions, grid_regions
from pipeline.route.regions.gates import gate_bit
from pipeline.route.regions.grid import grid_points


def test_counts_agree_with_an_independent_implementation(cross):
    """0.1 m, 10 degrees: 29,058 regions without start and goal, 11,584 of them gates, within half a percent."""
    assert len(cross.regions) - 2 == pytest.approx(29_058, rel=0.005)
    assert cross.regions.gate_count == pytest.approx(11_584, rel=0.005)


def test_start_and_goal_are_the_last_rows_exactly_at_their_poses(cross):
    """Whether or not the grid has them; their x is their own."""
    regions, task = cross.regions, cross.config.task
    assert (regions.start, regions.goal) == (len(regions) - 2, len(regions) - 1)
    for row, end in ((regions.start, task.start), (regions.goal, task.goal)):
        assert regions.controlled[row].tolist() == [end.x_m, end.y_m, end.z_m, 0.0, 0.0]
        assert regions.x_window_m[row].tolist() == [end.x_m, end.x_m]
        assert regions.gates[row] == 0
    assert regions.modes[[regions.start, regions.goal]].tolist() == [0, 7]
    assert not regions.controlled[:-2, 0].any()


def test_kappa_and_the_sign_of_det_h_are_those_of_the_statics_matrix(cross, statics):
    """Recomputed another way for every region."""
    regions = cross.regions
    H = statics(cross.machine, regions.pose, regions.q_m)
    np.testing.assert_allclose(np.linalg.cond(H, 2), regions.kappa, rtol=1e-6)
    np.testing.assert_array_equal(np.sign(np.linalg.det(H)), regions.det_sign)
    assert regions.kappa.max() < cross.config.route.kappa_max


def test_every_region_closes_all_links(cross, joints):
    """Link lengths follow from poses and actuators: fixed links have theirs, telescopes those of q."""
    regions, machine = cross.regions, cross.machine
    carts, platform, _ = joints(machine, regions.pose, regions.q_m)
    lengths = np.tile(machine.lengths_m, (len(regions), 1))
    lengths[:, [2, 4]] = regions.q_m[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(platform - carts, axis=2), lengths, atol=1e-9)


def test_gates_come_in_pairs_that_share_pose_and_carts_exactly(cross):
    """Nearly all gates have their twin in the other mode of their arm; every twin is the same bit for bit."""
    regions = cross.regions
    gates = np.flatnonzero(regions.gates)
    bits = gate_bit(regions.gates[gates])
    rows: dict[tuple, int] = {}
    for row, bit in zip(gates, bits, strict=True):
        rows.setdefault((regions.gates[row], regions.modes[row] | bit, *regions.controlled[row]), []).append(row)
    pairs = np.array([pair for pair in rows.values() if len(pair) == 2])
    assert len(pairs) * 2 == len(gates)
    np.testing.assert_array_equal(regions.pose[pairs[:, 0]], regions.pose[pairs[:, 1]])
    np.testing.assert_array_equal(regions.q_m[pairs[:, 0]], regions.q_m[pairs[:, 1]])
    np.testing.assert_array_equal(regions.kappa[pairs[:, 0]], regions.kappa[pairs[:, 1]])


def test_c_is_one_only_where_a_cart_is_abreast_of_its_joint(cross, joints):
    """D_k = 0 at the gates of arm k; at all other regions every arm is clearly L or R."""
    regions = cross.regions
    carts, platform, _ = joints(cross.machine, regions.pose, regions.q_m)
    along = (carts - platform)[:, [0, 1, 3], 0]
    own = regions.gates[:, None] == np.array([1, 2, 3])
    assert np.abs(along[own]).max() < 1e-9
    letters = (regions.modes[:, None] & np.array([4, 2, 1])) > 0
    np.testing.assert_array_equal((along > 0.0)[~own], letters[~own])


def test_link_distances_and_rail_distances_are_kept(cross_config, vary):
    """Asking for more room leaves exactly the regions that have it; no figure for rails means no check."""
    base = vary(
        cross_config,
        {"route.grid.y_m.min": 0.3, "route.grid.y_m.max": 0.6, "task.tilt_max_deg": 10},
    )
    machine = build_machine(base.machine)
    every = build_regions(base, machine).take(slice(0, -2))
    links, rails = min_distances(machine, every.pose, every.q_m[:, :3])
    np.testing.assert_array_equal(every.link_distance_m, links)
    assert links.min() >= 0.03
    strict = vary(base, {"machine.clearance.link_link_m": 0.05, "machine.clearance.link_rail_m": 0.2})
    kept = build_regions(strict, build_machine(strict.machine)).take(slice(0, -2))
    expected = every.take((links >= 0.05) & (rails >= 0.2))
    assert 0 < len(expected) < len(every)
    for field in fields(kept):
        np.testing.assert_array_equal(getattr(kept, field.name), getattr(expected, field.name))


def test_strokes_and_kappa_are_kept(cross_config, quick_config, vary):
    """Telescope limits and the kappa cap take away exactly the regions beyond them."""
    values = {"route.grid.y_m.min": 0.3, "route.grid.y_m.max": 0.6, "task.tilt_max_deg": 20}
    base = vary(cross_config, values)
    every = build_regions(base, build_machine(base.machine)).take(slice(0, -2))
    limited = vary(base, {"route.kappa_max": 30, "machine.links": quick_config.machine.links.model_dump()})
    machine = build_machine(limited.machine)
    kept = build_regions(limited, machine).take(slice(0, -2))
    telescopes = every.q_m[:, 3:]
    inside = ((telescopes >= machine.strokes_m[:, 0]) & (telescopes <= machine.strokes_m[:, 1])).all(axis=1)
    expected = every.take(inside & (every.kappa < 30))
    assert 0 < len(expected) < len(every)
    np.testing.assert_array_equal(kept.q_m, expected.q_m)


def test_x_windows_are_where_all_carts_are_on_their_rails(quick):
    """At either end of a window one cart is at the end of its rail and none beyond; outside one is."""
    regions, travel = quick.regions.take(slice(0, -2)), quick.machine.travel_m
    assert (regions.x_window_m[:, 0] <= regions.x_window_m[:, 1]).all()
    for end, outwards in ((0, -1e-6), (1, 1e-6)):
        carts = regions.q_m[:, :3] + regions.x_window_m[:, [end]]
        slack = np.minimum(carts - travel[:, 0], travel[:, 1] - carts).min(axis=1)
        np.testing.assert_allclose(slack, 0.0, atol=1e-12)
        carts += outwards
        assert (np.minimum(carts - travel[:, 0], travel[:, 1] - carts).min(axis=1) < 0.0).all()


@pytest.mark.parametrize("platform_x_m", [0.0, 0.01])
def test_the_grid_holds_what_trying_every_point_in_every_mode_finds(small_config, vary, platform_x_m):
    """On the platform's y axis and off it: nothing is lost where ry and reach are found for two modes of eight."""
    values = {"machine.links.l3a.platform_point_m": [platform_x_m, 0.1, 0.0], "route.grid.z_m.max": 0.6}
    config = vary(small_config, values)
    machine = build_machine(config.machine)
    table = grid_regions(config, machine)
    on_grid = table.take(table.gates == 0)
    points, modes = np.repeat(grid_points(config), 8, axis=0), np.tile(np.arange(8), len(grid_points(config)))
    solution = inverse_kinematics(machine, points, modes)
    pose, q = solution.pose[solution.reachable], solution.q_m[solution.reachable]
    kappa = condition_number(statics_matrix(machine, pose, q[:, :3]))
    keep = (kappa < config.route.kappa_max) & (min_distances(machine, pose, q[:, :3])[0] >= machine.link_link_m)
    assert 0 < len(on_grid) == keep.sum()
    np.testing.assert_array_equal(on_grid.modes, modes[solution.reachable][keep])
    np.testing.assert_allclose(on_grid.pose, pose[keep], atol=1e-12)
    np.testing.assert_allclose(on_grid.q_m, q[keep], atol=1e-12)
    np.testing.assert_allclose(on_grid.kappa, kappa[keep], rtol=1e-9)


def test_the_grid_knows_nothing_of_the_task(small, small_config, vary):
    """Another start leaves it as it is; the table is the grid and what the task adds."""
    grid = grid_regions(small_config, small.machine)
    other = vary(small_config, {"task.start.z_m": 0.8, "route.step_budget": 40})
    for table in (grid_regions(other, small.machine), small.regions.take(slice(0, -2))):
        for field in fields(table):
            np.testing.assert_array_equal(getattr(table, field.name), getattr(grid, field.name))


def test_little_memory_makes_small_blocks_and_the_same_table(small, small_config, vary):
    """Bit for bit, whatever the blocks are."""
    table = build_regions(vary(small_config, {"route.memory_gb": 0.002}), small.machine)
    for field in fields(table):
        np.testing.assert_array_equal(getattr(table, field.name), getattr(small.regions, field.name))


def test_short_rails_leave_out_what_does_not_fit_on_them(quick, quick_config, vary):
    """A region is kept exactly when its carts are less far apart than the rails are long."""
    rails = {f"machine.rails.{k}.travel_m": [0.0, 0.6] for k in range(3)}
    config = vary(quick_config, rails | {"task.goal.x_m": -0.5})
    kept = build_regions(config, build_machine(config.machine)).take(slice(0, -2))
    every = quick.regions.take(slice(0, -2))
    expected = every.take(np.ptp(every.q_m[:, :3], axis=1) <= 0.6)
    assert 0 < len(expected) < len(every)
    np.testing.assert_array_equal(kept.q_m, expected.q_m)


@given(st.floats(-3.0, 3.0))
def test_nothing_but_the_carts_depends_on_x(cross, x):
    """kappa, det H, distances and ry are the same wherever along the rails: x need not be a grid axis."""
    regions = cross.regions.take(slice(5, None, 977))
    moved = regions.controlled.copy()
    moved[:, 0] = x
    solution = inverse_kinematics(cross.machine, moved, regions.modes, regions.gates)
    along = (moved[:, :1] - regions.controlled[:, :1]) * [1.0, 1.0, 1.0, 0.0, 0.0]
    np.testing.assert_allclose(solution.q_m, regions.q_m + along, atol=1e-12)
    np.testing.assert_allclose(solution.pose[:, 4], regions.ry_rad, atol=1e-12)
    links, _ = min_distances(cross.machine, solution.pose, solution.q_m[:, :3])
    np.testing.assert_allclose(links, regions.link_distance_m, atol=1e-12)


def test_tilts_at_the_limit_are_regions(cross):
    """The grid includes the largest admitted tilt, and nothing is beyond it."""
    tilts = np.rad2deg(np.abs(cross.regions.controlled[:, 3:]))
    np.testing.assert_allclose(tilts.max(axis=0), 30.0)


def test_a_grid_out_of_reach_leaves_start_and_goal_alone(cross_config, vary):
    """An empty table is a table; whether there is a route is not its business."""
    config = vary(
        cross_config,
        {"route.grid.y_m": {"min": 5, "max": 5.2, "step": 0.1}, "task.tilt_max_deg": 0},
    )
    regions = build_regions(config, build_machine(config.machine))
    assert len(regions) == 2
    assert regions.gate_count == 0
    assert regions.pose.shape == (2, 6)


def test_a_start_on_a_grid_point_is_a_region_beside_its_twin(cross_config, vary):
    """The point y 0.3, z 0.9 without tilt is on the grid: the table has it twice, with the same figures."""
    regions = build_regions(vary(cross_config, {"task.tilt_max_deg": 0}), build_machine(cross_config.machine))
    same = np.isclose(regions.controlled[:, 1:], [0.3, 0.9, 0.0, 0.0]).all(axis=1) & (regions.modes == 0)
    assert np.flatnonzero(same)[-1] == regions.start
    assert same.sum() == 2
    assert np.ptp(regions.kappa[same]) < 1e-9


def test_take_keeps_whole_rows(small):
    """Row numbers and masks select the same in every column."""
    rows = np.array([7, 3, 3])
    picked = small.regions.take(rows)
    for field in fields(picked):
        np.testing.assert_array_equal(getattr(picked, field.name), getattr(small.regions, field.name)[rows])
    assert len(small.regions.take(small.regions.gates > 0)) == small.regions.gate_count


def test_progress_is_reported_with_growing_fractions(small_config, small):
    """Someone who waits sees how far it is."""
    seen = []
    build_regions(small_config, small.machine, Monitor(lambda message, fraction=None: seen.append((message, fraction))))
    assert len(seen) >= 2
    assert all(message.startswith("regions") for message, _ in seen)
    assert [fraction for _, fraction in seen] == sorted(fraction for _, fraction in seen)


def test_a_start_the_machine_cannot_be_at_is_refused_before_any_work(small_config, small, vary):
    """The error names the start."""
    with pytest.raises(ConfigError, match=r"task\.start"):
        build_regions(vary(small_config, {"task.start.z_m": 5.0}), small.machine)
