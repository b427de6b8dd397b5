"""The usable workspace: unions of intervals, symmetries, and volumes that converge."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import UsageError
from pipeline.machine import MODES, Machine, condition_number, inverse_kinematics, min_distances, statics_matrix
from pipeline.workspace.usable import Workspace, WorkspaceSetting, union_length, usable_windows, usable_workspace

COARSE = WorkspaceSetting(step_m=0.05)
MIRRORED_MODE = [MODES.index(mode.translate(str.maketrans("LR", "RL"))) for mode in MODES]

whole = st.integers(-20, 20)
intervals = st.lists(st.one_of(st.none(), st.tuples(whole, st.integers(0, 15))), min_size=1, max_size=8)


def mirrored(machine: Machine) -> Machine:
    """Reflect a machine in the plane x = 0: joints, travel, and the branch of its triangle."""
    flip = np.array([-1.0, 1.0, 1.0])
    return replace(
        machine,
        platform_points_m=machine.platform_points_m * flip,
        cart_offsets_m=machine.cart_offsets_m * flip,
        travel_m=-machine.travel_m[:, ::-1],
        triangle_sign=-machine.triangle_sign,
    )


def with_travel(machine: Machine, least: float, largest: float) -> Machine:
    """Give all three carts the same travel."""
    return replace(machine, travel_m=np.tile([least, largest], (3, 1)))


def rim_m3(workspace: Workspace) -> float:
    """Measure what stands on cells that do not have the same usable modes as all cells around them."""
    used = np.pad(workspace.lengths_m > 0.0, ((0, 0), (1, 1), (1, 1)))
    inner = used[:, 1:-1, 1:-1]
    around = [np.roll(used, shift, axis)[:, 1:-1, 1:-1] for axis in (1, 2) for shift in (-1, 1)]
    rim = np.any([other != inner for other in around], axis=(0, 1))
    return float(rim.sum() * workspace.setting.step_m**2 * workspace.union_m.max())


@pytest.fixture(scope="module")
def coarse(machine: Machine) -> Workspace:
    """Measure the reference machine on a coarse grid."""
    return usable_workspace(machine, COARSE)


@pytest.fixture(scope="module")
def finest_m3(machine: Machine) -> float:
    """Measure the union on a grid finer than any other of these tests."""
    return usable_workspace(machine, WorkspaceSetting(step_m=0.0025)).union_m3


@given(parts=intervals)
def test_union_counts_what_is_covered(parts: list[tuple[int, int] | None]) -> None:
    """The union of intervals with whole ends is as long as there are unit cells in any of them."""
    least = np.array([np.nan if part is None else part[0] for part in parts])
    length = np.array([np.nan if part is None else part[1] for part in parts])
    covered = {cell for part in parts if part is not None for cell in range(part[0], part[0] + part[1])}
    assert union_length(least, least + length) == len(covered)


def test_union_is_taken_cell_by_cell() -> None:
    """Columns do not mix, whatever the shape behind the first axis."""
    least = np.array([[[0.0, np.nan]], [[0.5, 2.0]]])
    largest = np.array([[[1.0, np.nan]], [[3.0, 2.5]]])
    assert union_length(least, largest).tolist() == [[3.0, 0.5]]


def test_union_lies_between_the_largest_and_the_sum(coarse: Workspace) -> None:
    """No cell's union is shorter than its longest interval, or longer than all of them together."""
    assert np.all(coarse.union_m >= coarse.lengths_m.max(axis=0) - 1e-12)
    assert np.all(coarse.union_m <= coarse.lengths_m.sum(axis=0) + 1e-12)
    assert coarse.volumes_m3.max() <= coarse.union_m3 <= coarse.volumes_m3.sum()


@pytest.mark.parametrize(("rx_deg", "rz_deg"), [(0.0, 0.0), (12.0, -8.0)])
def test_the_mirror_machine_swaps_left_and_right(machine: Machine, rx_deg: float, rz_deg: float) -> None:
    """Reflected in x, with rz reversed, the machine has the same workspaces in the opposite working modes."""
    rx, rz = np.deg2rad([rx_deg, rz_deg])
    here = usable_workspace(machine, replace(COARSE, rx_rad=rx, rz_rad=rz))
    there = usable_workspace(mirrored(machine), replace(COARSE, rx_rad=rx, rz_rad=-rz))
    assert there.volumes_m3[MIRRORED_MODE] == pytest.approx(here.volumes_m3)
    assert there.union_m3 == pytest.approx(here.union_m3)
    assert here.union_m3 > 0.5


def test_moving_all_rails_along_x_changes_nothing(machine: Machine, coarse: Workspace) -> None:
    """Only cart travel makes x matter alone: shifted travel shifts every interval."""
    shifted = usable_workspace(with_travel(machine, 1.0, 3.1), COARSE)
    assert shifted.least_m == pytest.approx(coarse.least_m + 1.0, nan_ok=True)
    assert shifted.union_m == pytest.approx(coarse.union_m)


def test_longer_rails_lengthen_every_interval(machine: Machine, coarse: Workspace) -> None:
    """A metre more of travel at the far end makes every usable interval a metre longer."""
    longer = usable_workspace(with_travel(machine, 0.0, 3.1), COARSE)
    used = coarse.lengths_m > 0.0
    assert longer.lengths_m[used] == pytest.approx(coarse.lengths_m[used] + 1.0)


@given(
    y=st.floats(-0.5, 1.2),
    z=st.floats(0.3, 1.35),
    mode=st.integers(0, 7),
    tilt=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4)),
    fraction=st.floats(-0.5, 1.5),
)
def test_an_interval_holds_what_is_usable(
    machine: Machine, y: float, z: float, mode: int, tilt: tuple[float, float], fraction: float
) -> None:
    """A pose is usable by the machine's own rules exactly when its x is within the interval."""
    window = usable_windows(machine, 40.0, np.array([[0.0, y, z, *tilt]]), np.array([mode]))[0]
    span = np.nan_to_num(window, nan=1.0)
    x = span[0] + fraction * (span[1] - span[0])
    solution = inverse_kinematics(machine, np.array([[x, y, z, *tilt]]), np.array([mode]))
    limits = machine.actuator_limits_m
    pose, q = solution.pose, solution.q_m
    usable = bool(solution.reachable[0]) and bool(np.all((q >= limits[:, 0] - 1e-12) & (q <= limits[:, 1] + 1e-12)))
    if usable:
        kappa = condition_number(statics_matrix(machine, pose, q[:, :3]))[0]
        usable = bool(kappa < 40.0 and min_distances(machine, pose, q[:, :3])[0][0] >= machine.link_link_m)
    inside = bool(window[0] - 1e-12 <= x <= window[1] + 1e-12)
    assert usable == inside


@settings(max_examples=40)
@given(kappa_max=st.floats(5.0, 200.0), more=st.floats(0.0, 100.0))
def test_a_milder_cap_never_takes_away(machine: Machine, kappa_max: float, more: float) -> None:
    """With a larger cap on kappa every working mode keeps what it has."""
    setting = WorkspaceSetting(kappa_max=kappa_max, step_m=0.1)
    strict = usable_workspace(machine, setting)
    mild = usable_workspace(machine, replace(setting, kappa_max=kappa_max + more))
    assert np.all(mild.lengths_m >= strict.lengths_m)


@pytest.mark.parametrize("mode", range(len(MODES)))
def test_clearance_takes_away_what_is_too_near(machine: Machine, mode: int) -> None:
    """Cells lost to a clearance are exactly those where some links are nearer to each other than that."""
    setting = WorkspaceSetting(step_m=0.02)
    free = usable_workspace(replace(machine, link_link_m=0.0), setting)
    z, y = np.nonzero(free.lengths_m[mode] > 0.0)
    controlled = np.zeros((len(y), 5))
    controlled[:, 1], controlled[:, 2] = free.y_m[y], free.z_m[z]
    solution = inverse_kinematics(machine, controlled, np.full(len(y), mode))
    distance, _ = min_distances(machine, solution.pose, solution.q_m[:, :3])
    clearance = float(np.median(distance))
    kept = usable_workspace(replace(machine, link_link_m=clearance), setting).lengths_m[mode][z, y] > 0.0
    assert np.array_equal(kept, distance >= clearance)


def test_rails_keep_links_away_where_asked_for(machine: Machine, coarse: Workspace) -> None:
    """A distance to other arms' rails takes away cells, and a large one all of them."""
    some = usable_workspace(replace(machine, link_rail_m=0.4), COARSE)
    assert np.all(some.lengths_m <= coarse.lengths_m)
    assert some.union_m3 < coarse.union_m3
    assert usable_workspace(replace(machine, link_rail_m=2.0), COARSE).union_m3 == 0.0


def test_rails_too_far_apart_leave_nothing(machine: Machine) -> None:
    """A machine whose links cannot meet has a workspace without cells."""
    apart = replace(machine, rails_m=machine.rails_m + np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 0.0]]))
    nothing = usable_workspace(apart, COARSE)
    assert nothing.union_m3 == 0.0
    assert nothing.volumes_m3.tolist() == [0.0] * 8


def test_reconfiguration_nearly_doubles_the_workspace(machine: Machine) -> None:
    """Without tilt, kappa < 40: all modes reach 1.9 to 2.0 times what all-left, or all-right, reaches alone."""
    workspace = usable_workspace(machine, WorkspaceSetting(step_m=0.01))
    ratios = workspace.union_m3 / workspace.volumes_m3[[0, 7]]
    assert np.all((ratios > 1.9) & (ratios < 2.0))


@pytest.mark.slow
@pytest.mark.parametrize("step_m", [0.08, 0.04, 0.02, 0.01, 0.005])
def test_volumes_converge_with_the_step(machine: Machine, finest_m3: float, step_m: float) -> None:
    """The error of the union is less than what stands on the cells of the rim, which alone are counted wrongly."""
    workspace = usable_workspace(machine, WorkspaceSetting(step_m=step_m))
    assert abs(workspace.union_m3 - finest_m3) < rim_m3(workspace)


@pytest.mark.slow
def test_the_rim_shrinks_with_the_step(machine: Machine) -> None:
    """A quarter of the step leaves less than half of the rim, though slivers come up that a coarse grid overlooks."""
    coarse, fine = (rim_m3(usable_workspace(machine, WorkspaceSetting(step_m=step_m))) for step_m in (0.02, 0.005))
    assert fine < coarse / 2.0


def test_more_cells_than_memory_are_not_computed(machine: Machine) -> None:
    """They are counted first, and the message has a step that would do."""
    with pytest.raises(UsageError, match=r"a step of 0\.0001 m makes 185,\d{3},\d{3} cells .* \(--step\)") as caught:
        usable_workspace(machine, WorkspaceSetting(step_m=1e-4))
    assert "at least 0.00064 m" in str(caught.value)
