"""The sequence of working modes along a path in a free corridor."""

import numpy as np

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.machine.geometry import MODE_SIGNS
from pipeline.refine import Path, refine_path, sample_path
from pipeline.refine.coarse import corner_parameters
from pipeline.refine.corridor import reach_along_rails
from pipeline.refine.sides import sides_at
from pipeline.route import Route


def test_both_ends_have_the_modes_of_the_route(route: Route, coarse: Path) -> None:
    """All L at the start, all R at the goal."""
    sides = sides_at(route, coarse, np.array([0.0, 1.0]))
    np.testing.assert_array_equal(sides, MODE_SIGNS[route.modes[[0, -1]]])


def test_an_arm_is_free_around_its_gate_and_nowhere_else(route: Route, coarse: Path) -> None:
    """Each of the three arms changes once: L, free, R, with its gate in the free part."""
    s = np.linspace(0.0, 1.0, 2_001)
    sides = sides_at(route, coarse, s)
    for arm in range(3):
        values = sides[:, arm][np.append(True, np.diff(sides[:, arm]) != 0.0)]
        np.testing.assert_array_equal(values, [-1.0, 0.0, 1.0])
        gate = corner_parameters(coarse)[np.flatnonzero(route.gates == arm + 1)]
        assert (sides[np.searchsorted(s, gate), arm] == 0.0).any()


def test_the_coarse_path_is_within(route: Route, coarse: Path, machine: Machine) -> None:
    """Carts are on the side that they have to be on, all along."""
    s = np.linspace(0.0, 1.0, 1_001)
    samples = sample_path(coarse, s)
    reach = reach_along_rails(machine, samples.pose, samples.q_m[:, :3])
    assert (sides_at(route, coarse, s) * reach > -1e-9).all()


def test_a_free_corridor_keeps_the_sequence_and_leaves_the_cells(
    light_config: Config, machine: Machine, route: Route
) -> None:
    """Carts change sides once each, in the order of the route; poses are where no cell of the route is."""
    refine = light_config.refine.model_copy(update={"corridor": "free"})
    result = refine_path(light_config.model_copy(update={"refine": refine}), machine, route)
    samples = sample_path(result.path, np.linspace(0.0, 1.0, 4_001))
    side = np.sign(reach_along_rails(machine, samples.pose, samples.q_m[:, :3]))
    changes = [np.flatnonzero(np.diff(side[:, arm])) for arm in range(3)]
    assert [len(change) for change in changes] == [1, 1, 1]
    _, first = np.unique(route.gates[route.gates > 0], return_index=True)
    assert np.argsort([change[0] for change in changes]).tolist() == np.argsort(first).tolist()
