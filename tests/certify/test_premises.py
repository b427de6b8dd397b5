"""The hash of what a proof rests on: what it does not read changes nothing."""

from typing import Any

import pytest

from pipeline.certify import premises_sha256
from pipeline.config import Config
from pipeline.config.file import dump_config, load_config, parse_config


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
