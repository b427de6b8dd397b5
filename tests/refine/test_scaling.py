"""Machines of any size have the same refined path."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import build_machine
from pipeline.refine import Refinement, refine_path
from pipeline.refine.measure import measure_path, sample_path
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes
from tests.scaling import scaled


@pytest.mark.slow
def test_refined_paths_are_the_same(light_config: Config, refinement: Refinement) -> None:
    """The same kappa, up to the nodes that failed checks add, and to the solver's tolerances, which are in metres."""
    config = scaled(light_config, 0.3)
    machine = build_machine(config.machine)
    route = plan_route(config, machine, build_regions(config, machine))
    paths = (refine_path(config, machine, route).path, refinement.path)
    found, expected = (
        measure_path(sample_path(path, np.linspace(0.0, 1.0, 2_001)), step_sizes(one.route))
        for path, one in zip(paths, (config, light_config), strict=True)
    )
    assert found.kappa_integral == pytest.approx(expected.kappa_integral, rel=1e-2)
    assert found.kappa_max == pytest.approx(expected.kappa_max, rel=1e-2)
    assert found.length == pytest.approx(expected.length, rel=2e-2)
