"""The machine with a spindle reconfigures, with all of its bodies apart."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.machine import build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from pipeline.route import build_regions, plan_route
from tests.conftest import CONFIGS

WINDOW = {"route.grid.y_m.min": 0.0, "route.grid.y_m.max": 0.5, "route.grid.z_m.min": 0.5, "route.grid.z_m.max": 1.1}
"""The part of the grid that the optimum over all of it is in."""


@pytest.fixture(scope="module")
def spindle_config() -> Config:
    """Load the machine with a spindle."""
    return load_config(CONFIGS / "spindle.yaml")


def test_its_joints_are_those_of_the_reference_machine(spindle_config: Config, bodies_config: Config) -> None:
    """All of them are moved alike, as a TCP elsewhere on the platform does."""
    links = [config.machine.model_dump()["links"] for config in (spindle_config, bodies_config)]
    moved = [np.subtract(link["platform_point_m"], links[1][key]["platform_point_m"]) for key, link in links[0].items()]
    np.testing.assert_allclose(moved, np.tile([-0.05, 0.25, 0.10], (6, 1)), atol=1e-12)


def test_the_spindle_is_a_real_one(spindle_config: Config) -> None:
    """It is 60 mm wide, 0.2 m long without its round ends, along the tool's axis, and its cutter ends at the TCP."""
    shapes = {body.name: body.capsule for body in spindle_config.machine.bodies if body.tool}
    spindle, cutter = shapes["spindle"], shapes["cutter"]
    assert spindle is not None
    assert cutter is not None
    assert 2.0 * spindle.radius_m == pytest.approx(0.06)
    np.testing.assert_allclose(np.subtract(spindle.to_m, spindle.from_m), [0.0, 0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(cutter.from_m, [0.0, cutter.radius_m, 0.0], atol=1e-12)
    assert cutter.to_m[1] > spindle.from_m[1] - spindle.radius_m


@pytest.mark.slow
def test_it_has_a_route_from_all_left_to_all_right(spindle_config: Config, vary, assert_rules) -> None:
    """The optimum of the whole grid, 457.672092, is found in a part of it."""
    config = vary(spindle_config, WINDOW)
    machine = build_machine(config.machine)
    route = plan_route(config, machine, build_regions(config, machine))
    assert_rules(config, machine, route)
    assert (route.mode_names[0], route.mode_names[-1]) == ("LLL", "RRR")
    assert route.objective == pytest.approx(457.672092, abs=1e-5)
    bodies = machine.bodies
    assert bodies is not None
    distances = body_distances(bodies, PoseSamples(machine, route.pose, route.q_m))
    assert distances.min() >= bodies.clearance_m
    assert any(name.startswith("spindle and link") for name in bodies.names)
