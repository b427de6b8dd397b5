"""What a path has to keep, beyond the limits of its poses."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.limits import path_limits
from pipeline.machine import Machine
from pipeline.refine import Path, Refinement
from pipeline.refine.measure import sample_path
from pipeline.refine.requirements import jumps, path_requirements, sign_changes
from pipeline.route import Route

S = np.linspace(0.0, 1.0, 2_001)


def test_a_singular_sample_counts_as_a_change_of_sign() -> None:
    """Zero is not a sign."""
    np.testing.assert_array_equal(sign_changes(np.array([1.0, 1.0, 0.0])), [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(sign_changes(np.array([-1.0, 1.0, 1.0])), [0.0, 1.0, 0.0])


def test_a_jump_to_another_assembly_is_found_where_it_happens(refinement: Refinement) -> None:
    """The pose does not move by many times its usual step."""
    samples = sample_path(refinement.path, S)
    assert not jumps(refinement.path, samples).any()
    pose = samples.pose.copy()
    pose[samples.s >= 0.15, 4] += 0.5
    found = jumps(refinement.path, replace(samples, pose=pose))
    np.testing.assert_array_equal(np.flatnonzero(found), [300])
    assert found.max() == pytest.approx(0.5, abs=0.01)


def test_every_limit_of_a_path_is_required(
    light_config: Config, machine: Machine, route: Route, refinement: Refinement
) -> None:
    """Rails only if the machine has a distance to them, a box for each to avoid."""
    for checked in (machine, replace(machine, link_rail_m=0.05)):
        path = replace(refinement.path, machine=checked)
        required = [part.what for part in path_requirements(light_config, route, path, refinement.coarse)]
        expected = [limit.wording.broken_path for limit in path_limits(light_config, checked)]
        assert [what for what in required if what in expected] == expected
        assert any("rail" in what for what in required) == np.isfinite(checked.link_rail_m)


def test_a_free_corridor_has_no_cells(light_config: Config, route: Route, coarse: Path) -> None:
    """The cells are required in a corridor of cells alone."""
    free = light_config.refine.model_copy(update={"corridor": "free"})
    for config, count in ((light_config, 1), (light_config.model_copy(update={"refine": free}), 0)):
        required = [part.what for part in path_requirements(config, route, coarse, coarse)]
        assert sum("outside the corridor" in what for what in required) == count


def test_margins_and_excess_agree(light_config: Config, route: Route, refinement: Refinement) -> None:
    """Each requirement has an excess above zero exactly where a margin is below."""
    samples = sample_path(refinement.coarse, S)
    for part in path_requirements(light_config, route, refinement.coarse, refinement.coarse):
        beyond = part.margins(samples) < 0.0
        excess = part.excess(samples)
        assert excess.shape == beyond.shape
        assert (excess[beyond] > 0.0).all(), part.what
        assert (excess[~beyond] <= 1e-12).all(), part.what
