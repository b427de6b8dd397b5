"""Positions of actuators for the controller, and in the geometry of the machine."""

from collections.abc import Callable

import numpy as np

from pipeline.config import Config
from pipeline.machine.actuator_space.controller_units import controller_units


def test_conversion_goes_there_and_back(agder_config: Config, vary: Callable):
    """Positions come back to rounding; at the middle of its range an actuator is off by its zero alone."""
    given = {"c2": {"zero_m": -4e-4}, "l3b": {"zero_m": 3e-4, "scale": 1.0002}}
    units = controller_units(vary(agder_config, {"machine.actuators": given}).machine)
    q = np.random.default_rng(1).uniform(0.0, 2.0, (50, 5))
    np.testing.assert_allclose(units.to_controller(units.to_geometry(q)), q, rtol=0.0, atol=1e-15)
    off = units.to_geometry(units.middles_m) - units.middles_m
    np.testing.assert_allclose(off, [0.0, -4e-4, 0.0, 0.0, 3e-4], atol=1e-15)
    step = units.to_controller(q + 1e-3) - units.to_controller(q)
    np.testing.assert_allclose(step, units.rates_to_controller(np.full_like(q, 1e-3)), rtol=1e-9)


def test_without_the_keys_nothing_changes(agder_config: Config):
    """Not even a bit of a position."""
    units = controller_units(agder_config.machine)
    q = np.random.default_rng(2).uniform(0.0, 2.0, (50, 5))
    np.testing.assert_array_equal(units.to_controller(q), q)
    np.testing.assert_array_equal(units.to_geometry(q), q)
    np.testing.assert_array_equal(units.rates_to_controller(q), q)
