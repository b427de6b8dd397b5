"""Gates: where arms pass their serial singularities on the grid's edges."""

import numpy as np
import pytest

from pipeline.machine import MODES, build_machine, inverse_kinematics
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.route.regions.gates import find_gates, gate_bit
from pipeline.route.regions.grid import grid_axes, grid_points


def _with_grid(vary, config, y, z, **more):
    axes = {name: dict(zip(("min", "max", "step"), values, strict=True)) for name, values in (("y_m", y), ("z_m", z))}
    return vary(config, {f"route.grid.{name}": axis for name, axis in axes.items()} | more)


@pytest.fixture(scope="module")
def gates(small_config):
    """Find the gates of the small problem, before any filter."""
    machine = build_machine(small_config.machine)
    controlled, modes, arms = find_gates(small_config, machine, grid_points(small_config))
    return machine, controlled, modes, arms


def test_every_arm_has_gates_and_d_is_zero_there(gates, joints):
    """D_k = L^2 - dy^2 - dz^2 computed from the joints vanishes: the serial singularity."""
    machine, controlled, modes, arms = gates
    assert set(arms) == {1, 2, 3}
    solution = inverse_kinematics(machine, controlled, modes, arms)
    ok = solution.reachable
    carts, platform, _ = joints(machine, solution.pose[ok], solution.q_m[ok])
    primary = np.array([0, 1, 3])
    across = (platform - carts)[:, primary, 1:]
    D = machine.lengths_m[primary] ** 2 - np.sum(across**2, axis=2)
    assert np.abs(D[np.arange(ok.sum()), arms[ok] - 1]).max() < 1e-9
    assert ok.sum() > 0.3 * len(ok)


def test_both_modes_of_a_gate_share_pose_and_carts_exactly(gates):
    """Bit for bit: a mode change costs no motion at all."""
    machine, controlled, modes, arms = gates
    here = inverse_kinematics(machine, controlled, modes, arms)
    there = inverse_kinematics(machine, controlled, modes ^ gate_bit(arms), arms)
    np.testing.assert_array_equal(here.pose, there.pose)
    np.testing.assert_array_equal(here.q_m, there.q_m)


def test_gates_lie_on_edges_along_y_or_z(gates, small_config):
    """All other coordinates are those of grid points, and the moving one is within the grid."""
    _, controlled, _, _ = gates
    y, z, rx, rz = grid_axes(small_config)
    on = [np.isclose(controlled[:, [k + 1]], axis, atol=1e-12).any(axis=1) for k, axis in enumerate((y, z, rx, rz))]
    assert (on[0] | on[1]).all()
    assert (on[2] & on[3]).all()
    assert controlled[:, 1].min() >= y[0]
    assert controlled[:, 2].max() <= z[-1]


def test_gates_of_arm_3_without_tilt_lie_on_a_circle_around_its_rail(cross_config, vary):
    """(y + 0.1)^2 + z^2 = 1.25^2: the crossings of that circle with the grid lines, in all eight modes."""
    config = vary(cross_config, {"task.tilt_max_deg": 0})
    machine = build_machine(config.machine)
    controlled, modes, arms = find_gates(config, machine, grid_points(config))
    y, z = grid_axes(config)[:2]
    expected = {(round(float(np.sqrt(1.25**2 - h**2)) - 0.1, 9), round(h, 9)) for h in z if h <= 1.25}
    expected |= {(round(v, 9), round(float(np.sqrt(1.25**2 - (v + 0.1) ** 2)), 9)) for v in y if abs(v + 0.1) <= 1.25}
    expected = {(v, h) for v, h in expected if y[0] <= v <= y[-1] and z[0] <= h <= z[-1]}
    for mode in range(8):
        mine = controlled[(arms == 3) & (modes == mode)]
        assert {(round(v, 9), round(h, 9)) for v, h in mine[:, 1:3].tolist()} == expected


@pytest.mark.parametrize("arm", [1, 2])
def test_no_gate_of_arms_1_and_2_is_missed_or_made_up(arm, cross_config, vary):
    """On each edge the sign of D, computed at its ends alone, says whether there is one gate or none."""
    config = _with_grid(
        vary, cross_config, (0.0, 0.9, 0.1), (0.3, 0.9, 0.1), **{"task.tilt_max_deg": 10, "task.locked_axes": ["rx"]}
    )
    machine = build_machine(config.machine)
    lattice = grid_points(config)
    shape = tuple(len(axis) for axis in grid_axes(config))
    controlled, modes, arms = find_gates(config, machine, lattice)
    for mode in (MODES.index("LLL"), MODES.index("RRR")):
        solution = inverse_kinematics(machine, lattice, np.full(len(lattice), mode))
        # Arm 3 holds ry wherever it is in reach; elsewhere D of the others is not compared.
        positive = (solution.discriminants_m2[:, arm - 1] > 0.0).reshape(shape)
        known = (solution.discriminants_m2[:, [arm - 1, 2]] > -np.inf).all(axis=1).reshape(shape)
        known &= (solution.discriminants_m2[:, 2] > 0.0).reshape(shape)
        crossed = sum(
            np.count_nonzero((np.diff(positive.astype(int), axis=axis) != 0) & _both(known, axis)) for axis in (0, 1)
        )
        mine = controlled[(arms == arm) & (modes == mode)]
        ends_known = [_edge_known(point, config, known) for point in mine]
        assert sum(ends_known) == crossed > 5


def _both(known, axis):
    n = known.shape[axis]
    return np.take(known, np.arange(n - 1), axis) & np.take(known, np.arange(1, n), axis)


def _edge_known(point, config, known):
    """Whether both grid points of the edge a gate lies on are known."""
    axes = grid_axes(config)
    lower = tuple(int(np.searchsorted(axis, value + 1e-9) - 1) for axis, value in zip(axes, point[1:], strict=True))
    off = [k for k in (0, 1) if abs(axes[k][lower[k]] - point[k + 1]) > 1e-9]
    upper = list(lower)
    for k in off:
        upper[k] += 1
    return bool(known[lower] and known[tuple(upper)])


def test_a_grid_point_exactly_at_a_serial_singularity_has_a_gate(cross_config, vary):
    """0.75^2 + 1^2 = 1.25^2: at y 0.65, z 1 arm 3 is abreast of its joint, and nowhere on the edges around."""
    config = _with_grid(vary, cross_config, (0.55, 0.75, 0.1), (0.9, 1.1, 0.1), **{"task.tilt_max_deg": 0})
    machine = build_machine(config.machine)
    controlled, modes, arms = find_gates(config, machine, grid_points(config))
    there = (arms == 3) & np.isclose(controlled[:, 1], 0.65) & np.isclose(controlled[:, 2], 1.0)
    assert set(modes[there]) == set(range(8))


def test_gates_of_arm_3_are_found_off_the_axis(cross_config, vary, joints):
    """With a_3a off the platform's y axis D_3 is coupled with ry; D is zero at the gates all the same."""
    config = _with_grid(vary, cross_config, (0.4, 0.8, 0.1), (0.7, 1.0, 0.1), **{"task.tilt_max_deg": 10})
    config = vary(
        config,
        {
            "machine.links.l3a.platform_point_m": [0.02, 0.10, 0.01],
            "machine.links.l3c.platform_point_m": [0.13, 0.10, 0.0],
        },
    )
    machine = build_machine(config.machine)
    controlled, modes, arms = find_gates(config, machine, grid_points(config))
    third = arms == 3
    assert third.sum() > 8 * 20
    solution = inverse_kinematics(machine, controlled[third], modes[third], arms[third])
    assert solution.reachable.mean() > 0.5
    pose, q = solution.pose[solution.reachable], solution.q_m[solution.reachable]
    carts, platform, _ = joints(machine, pose, q)
    vector = (platform - carts)[:, 3]
    np.testing.assert_allclose(vector[:, 0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(vector, axis=1), 1.25, atol=1e-7)
    other = inverse_kinematics(machine, controlled[third], modes[third] ^ 1, arms[third])
    np.testing.assert_array_equal(solution.pose, other.pose)
    np.testing.assert_array_equal(solution.q_m, other.q_m)


def test_a_grid_out_of_reach_has_no_gates(cross_config, vary):
    """No edge changes sign, and the arrays are empty but well-shaped."""
    config = _with_grid(vary, cross_config, (5.0, 5.3, 0.1), (5.0, 5.3, 0.1))
    controlled, modes, arms = find_gates(config, build_machine(config.machine), grid_points(config))
    assert controlled.shape == (0, 5)
    assert len(modes) == len(arms) == 0


def test_gate_bit_is_the_bit_of_the_arm_whose_mode_may_change():
    """Flipping it turns the letter of that arm and no other."""
    assert gate_bit(np.array([0, 1, 2, 3])).tolist() == [0, 4, 2, 1]
    for mode in range(8):
        for arm in (1, 2, 3):
            flipped = mode ^ int(gate_bit(np.array([arm]))[0])
            assert np.flatnonzero(MODE_SIGNS[mode] != MODE_SIGNS[flipped]).tolist() == [arm - 1]
