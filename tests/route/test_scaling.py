"""Machines of any size have the same regions, routes and reasons for having none."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.limits import relaxations
from pipeline.machine import build_machine
from pipeline.route import build_regions, plan_route
from pipeline.route.diagnosis.search import relax_limit
from tests.conftest import CONFIGS, WITHOUT_FORCE_LIMITS
from tests.scaling import scaled


@pytest.fixture(scope="module")
def coarse(vary: Callable) -> Config:
    """Take tiny.yaml with a tilt grid of 10 degrees: a route exists with 10 degrees of tilt."""
    tilts = {"route.grid.rx_step_deg": 10, "route.grid.rz_step_deg": 10, "task.tilt_max_deg": 10}
    return vary(load_config(CONFIGS / "tiny.yaml"), WITHOUT_FORCE_LIMITS | tilts)


@pytest.mark.parametrize("k", [0.13, 3.7])
def test_regions_routes_and_reasons(coarse: Config, vary: Callable, k: float):
    """The same regions, the same cost, and the same tilt with which there is a route at all."""
    found = []
    for config in (coarse, scaled(coarse, k)):
        machine = build_machine(config.machine)
        regions = build_regions(config, machine)
        route = plan_route(config, machine, regions)
        flat = vary(config, {"task.tilt_max_deg": 0})
        tilt = next(limit for limit in relaxations(flat, machine) if limit.key == "task.tilt_max_deg")
        finding = relax_limit(flat, machine, tilt, lambda message, fraction=None: None)
        found.append((regions, route, finding))
    (one, route, finding), (other, other_route, other_finding) = found
    np.testing.assert_allclose(other.kappa, one.kappa, rtol=1e-9)
    np.testing.assert_array_equal(other.modes, one.modes)
    assert other_route.objective == pytest.approx(route.objective, rel=1e-9)
    np.testing.assert_array_equal(other_route.modes, route.modes)
    assert (other_finding.verdict, other_finding.value) == (finding.verdict, finding.value)
    assert other_finding.objective == pytest.approx(finding.objective, rel=1e-9)
