"""Routes on rails that are off X: found for parallel ones, then placed on those that are there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine, build_machine
from pipeline.machine.kinematics import closure_residual
from pipeline.machine.rails import with_parallel_rails
from pipeline.machine.samples import PoseSamples
from pipeline.machine.working_modes import working_modes
from pipeline.refine.coarse import coarse_path
from pipeline.route.metric import step_sizes
from pipeline.route.own_rails import on_own_rails
from pipeline.route.planner import plan_route
from pipeline.route.regions import RegionTable, build_regions, task_endpoints
from pipeline.route.result import Route
from tests.conftest import CONFIGS

SLOPES = {
    f"machine.rails.{k}.slopes": slopes for k, slopes in enumerate([(0.002, -0.003), (-0.001, 0.003), (0.0, 0.002)])
}


@pytest.fixture(scope="module")
def config(vary: Callable[..., Config]) -> Config:
    """Give the machine of tiny.yaml rails that are off X."""
    return vary(load_config(CONFIGS / "tiny.yaml"), SLOPES)


@pytest.fixture(scope="module")
def own(config: Config) -> Machine:
    """Build it."""
    return build_machine(config.machine)


@pytest.fixture(scope="module")
def regions(config: Config, own: Machine) -> RegionTable:
    """Compute its regions."""
    return build_regions(config, own)


@pytest.fixture(scope="module")
def route(config: Config, own: Machine, regions: RegionTable) -> Route:
    """Plan its route."""
    return plan_route(config, own, regions)


def test_regions_are_those_of_parallel_rails(config: Config, own: Machine, regions: RegionTable):
    """To the bit, ends included: x enters through the carts alone."""
    parallel = build_regions(config, with_parallel_rails(own))
    for name in ("controlled", "q_m", "kappa", "x_window_m"):
        np.testing.assert_array_equal(getattr(regions, name), getattr(parallel, name))


def test_every_step_is_on_the_rails_as_they_are(config: Config, own: Machine, route: Route):
    """Links close, modes are those of the route away from gates, and start and goal are where the task has them."""
    assert np.abs(closure_residual(own, route.pose, route.q_m)).max() < 1e-9
    samples = PoseSamples(own, route.pose, route.q_m)
    np.testing.assert_array_equal(route.kappa, samples.kappa)
    away = (np.abs(samples.reach_m) > 0.1).all(axis=1)
    assert away[[0, -1]].all()
    np.testing.assert_array_equal((working_modes(samples.reach_m) > 0.0)[away] @ [4, 2, 1], route.modes[away])
    for end, row in zip(task_endpoints(config, own), (0, -1), strict=True):
        np.testing.assert_allclose(route.pose[row], end.pose, atol=1e-12)
        np.testing.assert_allclose(route.q_m[row], end.q_m, atol=1e-12)


def test_its_moves_can_be_followed_there(config: Config, own: Machine, route: Route):
    """From step to step, on one branch; the arms change their modes as on the route."""
    path = coarse_path(own, route, step_sizes(config.route))
    modes = working_modes(PoseSamples(own, path.node_pose, path.q(path.node_s)).reach_m)
    assert np.count_nonzero(np.diff(modes, axis=0)) == route.mode_changes


def test_parallel_rails_leave_a_route_alone_and_rails_too_far_off_are_reported(
    config: Config, own: Machine, route: Route
):
    """The latter with the step."""
    assert on_own_rails(config, with_parallel_rails(own), route) is route
    far = replace(own, rails_m=own.rails_m + 3.0)
    with pytest.raises(NoSolutionError, match=r"step \d+ of the route.* out of reach"):
        on_own_rails(config, far, route)
