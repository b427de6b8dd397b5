"""Limits of all drives of a kind or of each, and forces that differ for push and pull."""

from typing import Any

import numpy as np
import pytest
import yaml

from pipeline.config import Config
from pipeline.config.file import dump_config, parse_config
from pipeline.config.machine.limits import push_and_pull
from pipeline.errors import ConfigError
from pipeline.machine import build_machine
from tests.conftest import CONFIGS

CART = {"velocity_mps": 0.5, "acceleration_mps2": 2.0, "jerk_mps3": 40.0, "force_n": 400.0}
TELESCOPE = {"velocity_mps": 0.1, "acceleration_mps2": 0.5}
EACH_CART = {"c1": CART, "c2": {**CART, "velocity_mps": 0.4}, "c3": {**CART, "force_n": {"push": 300, "pull": 500}}}
SECTION = "is missing; allowed is a section with the keys velocity_mps, acceleration_mps2, jerk_mps3, force_n"
FORCE = "allowed is a number above 0, at most 1e+06"


def with_limits(**limits: Any) -> Any:
    """Give the reference configuration with other limits."""
    data = yaml.safe_load((CONFIGS / "agder.yaml").read_text())
    data["machine"]["limits"].update(limits)
    return data


def messages(**limits: Any) -> list[str]:
    """Tell what is wrong with limits, without the path that they have in common."""
    with pytest.raises(ConfigError) as error:
        parse_config(with_limits(**limits))
    return [f"{issue.path}: {issue.message}".removeprefix("machine.limits.") for issue in error.value.issues]


def test_one_section_is_for_all_drives_of_its_kind(agder_config: Config) -> None:
    """Three carts and two telescopes."""
    limits = agder_config.machine.limits.of_actuators()
    assert [one.velocity_mps for one in limits] == [0.5, 0.5, 0.5, 0.1, 0.1]
    assert agder_config.machine.limits.of_forces() == ["carts.force_n", "telescopes.force_n", "link_force_n"]


def test_every_drive_may_have_a_section() -> None:
    """Each limit reaches its own drive; push and pull stay apart."""
    each = {"l2b": TELESCOPE, "l3b": {"velocity_mps": 0.2, "acceleration_mps2": 0.6, "force_n": 70.0}}
    config = parse_config(with_limits(carts=EACH_CART, telescopes=each, link_force_n={"push": 600, "pull": 900}))
    machine = build_machine(config.machine)
    assert machine.velocity_mps.tolist() == [0.5, 0.4, 0.5, 0.1, 0.2]
    assert machine.acceleration_mps2.tolist() == [2.0, 2.0, 2.0, 0.5, 0.6]
    assert machine.jerk_mps3.tolist() == [40.0, 40.0, 40.0, np.inf, np.inf]
    push, pull = machine.force_limits_n
    assert push.tolist() == [400.0, 400.0, 300.0, np.inf, 70.0, *[600.0] * 6]
    assert pull.tolist() == [400.0, 400.0, 500.0, np.inf, 70.0, *[900.0] * 6]
    forces = ["carts.c1", "carts.c2", "carts.c3", "telescopes.l3b"]
    assert config.machine.limits.of_forces() == [*(f"{key}.force_n" for key in forces), "link_force_n"]


def test_it_is_written_as_it_was_given() -> None:
    """The resolved configuration is read back, and means the same."""
    config = parse_config(with_limits(carts=EACH_CART))
    written = yaml.safe_load(dump_config(config))
    assert written["machine"]["limits"]["carts"]["c3"]["force_n"] == {"push": 300.0, "pull": 500.0}
    assert parse_config(written) == config


@pytest.mark.parametrize(
    ("carts", "expected"),
    [
        ({key: EACH_CART[key] for key in ("c1", "c3")}, [f"carts.c2: {SECTION}"]),
        ({**EACH_CART, "c4": CART}, ["carts.c4: is not a known key; allowed here are c1, c2, c3"]),
        ({**EACH_CART, "force_n": 3.0}, ["carts.force_n: is not a known key; allowed here are c1, c2, c3"]),
        ({**EACH_CART, "c2": None}, [f"carts.c2: is null; {SECTION.split('; ')[1]}"]),
        ({**EACH_CART, "c2": {**CART, "jerk": 1}}, ["carts.c2.jerk: is not a known key (did you mean jerk_mps3?)"]),
        ({**CART, "force_n": {"push": 10.0}}, [f"carts.force_n.pull: is missing; {FORCE}"]),
        ({**CART, "force_n": {"push": 10.0, "pull": -1}}, [f"carts.force_n.pull: is -1; {FORCE}"]),
        ({**CART, "force_n": {"push": 10.0, "pull": True}}, [f"carts.force_n.pull: is true; {FORCE}"]),
        (
            {**CART, "force_n": {"push": 10.0, "pull": 1, "turn": 1}},
            ["carts.force_n.turn: is not a known key; allowed here are push, pull"],
        ),
        (
            {**CART, "force_n": "much"},
            [f'carts.force_n: is "much"; {FORCE} or a section with the keys push, pull or null'],
        ),
        (
            [CART, CART, CART],
            ["carts: is [{"],
        ),
        (7, [f"carts: is 7; {SECTION.split('; ')[1]} or a section with the keys c1, c2, c3"]),
    ],
)
def test_what_is_missing_or_unknown_is_told_with_its_key(carts: Any, expected: list[str]) -> None:
    """The key's path is that in the file, whichever of the two forms was meant."""
    found = messages(carts=carts)
    assert len(found) == len(expected)
    for message, start in zip(found, expected, strict=True):
        assert message.startswith(start)


def test_drives_of_the_other_kind_are_not_known() -> None:
    """Telescopes among the carts: the three that are missing, and the two that do not belong there."""
    found = messages(carts={"l2b": TELESCOPE, "l3b": TELESCOPE})
    assert [message.split(":")[0] for message in found] == [f"carts.{key}" for key in ("c1", "c2", "c3", "l2b", "l3b")]


def test_all_forces_are_multiplied(agder_config: Config) -> None:
    """Push and pull, of every drive and link; nothing else changes."""
    config = parse_config(with_limits(carts=EACH_CART, link_force_n={"push": 600, "pull": 900}))
    more = config.machine.limits.with_forces(2.5)
    before, after = (
        build_machine(config.machine.model_copy(update={"limits": limits})) for limits in (config.machine.limits, more)
    )
    np.testing.assert_allclose(after.force_limits_n, 2.5 * before.force_limits_n)
    assert after.velocity_mps.tolist() == before.velocity_mps.tolist()
    assert more.carts.c3.force_n is not None
    assert push_and_pull(more.carts.c3.force_n) == (750.0, 1250.0)


def test_what_holding_depends_on(agder_config: Config) -> None:
    """Forces, in the form in which they are given, and no other limits."""
    assert agder_config.machine.limits.holding() == {
        "carts": {"force_n": 400.0},
        "telescopes": {"force_n": 1000.0},
        "link_force_n": 2000.0,
        "holding_fraction": 1.0,
    }
    config = parse_config(with_limits(carts=EACH_CART))
    forces = {key: {"force_n": 400.0} for key in ("c1", "c2")}
    assert config.machine.limits.holding()["carts"] == {**forces, "c3": {"force_n": {"push": 300.0, "pull": 500.0}}}


def test_a_limit_of_stiffness_is_part_of_what_holding_depends_on() -> None:
    """Where it is given; it is negative, as the least stiffness by gravity is everywhere, and needs masses."""
    limits = parse_config(with_limits(gravity_stiffness_npm=-6e3)).machine.limits
    assert limits.holding()["gravity_stiffness_npm"] == -6e3
    assert "gravity_stiffness_npm" in limits.of_forces()
    for value in (0.0, 10.0):
        (message,) = messages(gravity_stiffness_npm=value)
        assert message.endswith("allowed is a number from -1e+09 to less than 0 or null")
    data = with_limits(carts=TELESCOPE, telescopes=TELESCOPE, link_force_n=None, gravity_stiffness_npm=-6e3)
    data["machine"]["dynamics"] = None
    with pytest.raises(ConfigError, match=r"leave out machine\.limits\.gravity_stiffness_npm"):
        parse_config(data)


def test_force_limits_of_single_drives_need_masses_too() -> None:
    """The key of the drive is named."""
    data = with_limits(carts=EACH_CART)
    data["machine"]["dynamics"] = None
    with pytest.raises(ConfigError, match=r"against machine\.limits\.carts\.c1\.force_n"):
        parse_config(data)
