"""A route to refine, and the quickest way to refine it."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Path, Refinement, coarse_path, refine_path
from pipeline.route import Route, build_regions, plan_route
from pipeline.route.metric import step_sizes


@pytest.fixture(scope="session")
def steps(quick_config: Config) -> np.ndarray:
    """Give the largest moves per step of the coarse grid."""
    return step_sizes(quick_config.route)


@pytest.fixture(scope="session")
def route(quick_config: Config, machine: Machine) -> Route:
    """Plan the route of quick.yaml."""
    return plan_route(quick_config, machine, build_regions(quick_config, machine))


@pytest.fixture(scope="session")
def coarse(machine: Machine, route: Route, steps: np.ndarray) -> Path:
    """Join the steps of the route."""
    return coarse_path(machine, route, steps)


@pytest.fixture(scope="session")
def light_config(quick_config: Config) -> Config:
    """Make a configuration that is refined in a few seconds."""
    light = quick_config.refine.model_copy(
        update={"nodes": 50, "coefficients": 22, "check_points": 2_000, "max_meshes": 1}
    )
    return quick_config.model_copy(update={"refine": light})


@pytest.fixture(scope="session")
def refinement(light_config: Config, machine: Machine, route: Route) -> Refinement:
    """Refine the route of quick.yaml."""
    return refine_path(light_config, machine, route)
