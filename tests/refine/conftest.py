"""A route to refine, and the quickest way to refine it."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.choices import RouteObjective
from pipeline.limits import node_limits
from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path, Refinement, coarse_path, refine_path
from pipeline.refine.corridor.cells import corridor
from pipeline.refine.peak.constraints import LeastValues, PathConstraints
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate, iterate_at
from pipeline.refine.peak.problem import PeakProblem
from pipeline.refine.splines import clamped_knots, fit
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


@pytest.fixture(scope="session")
def free() -> np.ndarray:
    """Let both ends be reached from anywhere."""
    return np.full((2, 5), np.nan)


@pytest.fixture(scope="session")
def steep_config(quick_config: Config) -> Config:
    """Make a configuration whose route zigzags, in a narrow corridor: one that leaves much to lower."""
    return quick_config.model_copy(
        update={
            "route": quick_config.route.model_copy(update={"objective": RouteObjective.SUM}),
            "refine": quick_config.refine.model_copy(update={"corridor_cells": 1.0}),
        }
    )


@pytest.fixture(scope="session")
def steep_route(steep_config: Config, machine: Machine) -> Route:
    """Plan it."""
    return plan_route(steep_config, machine, build_regions(steep_config, machine))


@pytest.fixture(scope="session")
def steep(machine: Machine, steep_route: Route, steps: np.ndarray) -> Path:
    """Join its steps."""
    return coarse_path(machine, steep_route, steps)


@pytest.fixture(scope="session")
def peak(
    steep_config: Config, machine: Machine, steep_route: Route, steep: Path, steps: np.ndarray, free
) -> PeakProblem:
    """Evaluate splines of sixteen coefficients at 61 points along a route, with no margin to any limit."""
    points = EvaluationPoints(machine, np.linspace(0.0, 1.0, 61), clamped_knots(16), steps, 64.0)
    samples = PoseSamples(machine, steep.pose(points.s), steep.q(points.s))
    limits = [
        LeastValues(limit, np.full(limit.values(samples).shape, limit.least))
        for limit in node_limits(steep_config, machine)
    ]
    required = PathConstraints(corridor(steep_config, steep_route, steep, points.s), limits)
    return PeakProblem(points, required, free, machine.actuator_limits_m)


@pytest.fixture(scope="session")
def points(peak: PeakProblem) -> EvaluationPoints:
    """Give the points."""
    return peak.points


@pytest.fixture(scope="session")
def iterate(points: EvaluationPoints, steep: Path) -> Iterate:
    """Fit the splines to the path along that route."""
    found = iterate_at(points, fit(points.knots, steep.node_s, steep.q(steep.node_s)), steep.pose(points.s))
    assert found is not None
    return found


@pytest.fixture
def direction(iterate: Iterate) -> np.ndarray:
    """Give a random change of the coefficients that leaves both ends where they are."""
    change = np.random.default_rng(2).normal(size=iterate.coefficients.shape)
    change[[0, -1]] = 0.0
    return change
