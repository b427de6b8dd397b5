"""The hash of what a proof rests on: what it does not read changes nothing."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pipeline.certify import premises_sha256
from pipeline.config import Config
from pipeline.config.file import dump_config, load_config, parse_config
from pipeline.errors import ConfigError
from pipeline.limits.kappa import path_cap
from pipeline.limits.tilt import path_limits_deg
from pipeline.machine import build_machine
from pipeline.machine.masses import lumped_platform
from pipeline.route.regions.endpoints import controlled_pose


def changed(config: Config, keys: str, value: Any) -> Config:
    """Change one key of a configuration."""
    data = config.model_dump(mode="json")
    *sections, key = keys.split(".")
    part = data
    for section in sections:
        part = part[section]
    part[key] = value
    return parse_config(data)


READ: tuple[tuple[str, Any], ...] = (
    ("machine.links.l1.length_m", 1.1),
    ("machine.links.l2b.cart_cone", {"axis": [0.0, 0.0, -1.0], "half_angle_deg": 70.0}),
    ("machine.clearance.link_link_m", 0.02),
    ("machine.clearance.link_rail_m", 0.01),
    ("task.start.x_m", 1.0),
    ("task.goal.mode", "LRR"),
    ("task.tilt_max_deg", 29.0),
    ("task.locked_axes", ["rz"]),
    ("route.kappa_max", 90.0),
    ("refine.kappa_max", 50.0),
    ("machine.dynamics.load_kg", 1.0),
    ("machine.limits.telescopes.force_n", 900.0),
    ("machine.limits.holding_fraction", 0.9),
    ("machine.limits.gravity_stiffness_npm", -9_000.0),
    ("machine.limits.link_force_n", {"push": 2000.0, "pull": 1900.0}),
    ("machine.characteristic_length_m", 0.9),
    ("refine.travel_margin_m", 0.004),
    ("refine.stroke_margin_m", 0.001),
    ("task.visit", [{"pose": {"x_m": 1.0, "y_m": 0.3, "z_m": 0.9, "mode": "LLL"}}]),
)
UNREAD: tuple[tuple[str, Any], ...] = (
    ("name", "other"),
    ("machine.limits.carts.velocity_mps", 0.4),
    ("machine.dynamics.platform.inertia_kgm2", (0.2, 0.2, 0.2)),
    ("task.budget.travel_m", 9.0),
    ("route.x_step_m", 0.2),
    ("refine.nodes", 90),
    ("certify.kappa_excess", 0.5),
    ("retime.speed", 0.5),
)


@pytest.mark.parametrize(("keys", "value"), READ)
def test_machine_limits_and_ends_count(agder_config: Config, keys: str, value: Any) -> None:
    """Each of them is another proof."""
    assert premises_sha256(changed(agder_config, keys, value)) != premises_sha256(agder_config)


@pytest.mark.parametrize(("keys", "value"), UNREAD)
def test_nothing_else_does(agder_config: Config, keys: str, value: Any) -> None:
    """How a path was found, and what becomes of it in time."""
    assert premises_sha256(changed(agder_config, keys, value)) == premises_sha256(agder_config)


def test_a_configuration_read_again_is_the_same(agder_config: Config, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Through the file that is beside the certificate."""
    file = tmp_path_factory.mktemp("run") / "config.yaml"
    file.write_text(dump_config(agder_config))
    assert premises_sha256(load_config(file)) == premises_sha256(agder_config)


def _numbers(section: dict[str, Any] | list[Any], keys: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """List where a configuration has numbers."""
    for key, value in section.items() if isinstance(section, dict) else enumerate(section):
        if isinstance(value, dict | list):
            yield from _numbers(value, (*keys, key))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield (*keys, key)


def _read_by_the_check(config: Config) -> list[Any]:
    """Collect all numbers that the check of a certificate computes with, or compares with."""
    machine, task = build_machine(config.machine), config.task
    assert machine.masses is not None
    body = lumped_platform(machine.masses, machine.platform_points_m)
    geometry = (machine.rails_m, machine.platform_points_m, machine.cart_offsets_m, machine.lengths_m)
    limits = (
        machine.actuator_limits_m,
        machine.link_link_m,
        machine.link_rail_m,
        machine.force_n,
        machine.link_force_n,
    )
    forces = (machine.holding_fraction, machine.masses.gravity_mps2, machine.masses.friction_n, body.mass_kg)
    asked = (path_cap(config), path_limits_deg(config), controlled_pose(task.start), controlled_pose(task.goal))
    return [np.array(value).tolist() for value in (*geometry, *limits, *forces, body.centre_m, *asked)]


def test_every_number_that_the_check_reads_counts(agder_config: Config) -> None:
    """Whichever number of a configuration changes what is read, the hash changes with it."""
    full = changed(changed(agder_config, "machine.clearance.link_rail_m", 0.01), "machine.limits.link_force_n", 5e3)
    data, read, known, counted = full.model_dump(mode="json"), _read_by_the_check(full), premises_sha256(full), 0
    for place in list(_numbers(data)):
        part = data
        for key in place[:-1]:
            part = part[key]
        was = part[place[-1]]
        part[place[-1]] = was * 1.001 if was else 1e-3
        try:
            other = parse_config(data)
        except ConfigError:
            other = full
        part[place[-1]] = was
        if str(_read_by_the_check(other)) != str(read):
            counted += 1
            assert premises_sha256(other) != known, place
    assert counted > 60
