"""The section of the drives: per kind or per drive, with defaults; what it refuses is named by its key."""

import pytest

from pipeline.config import Config
from pipeline.config.file import dump_config, parse_config
from tests.config.test_config import AGDER, messages, with_value


def test_drives_are_given_by_kind_or_one_by_one() -> None:
    """A section for all of a kind, or one for each; what is not given is assumed, and differs between the kinds."""
    config = parse_config(
        with_value("drives.carts.c2.position_gain_per_s", 5.0, "drives.telescopes.velocity_gain_nspm", 9_000.0)
    )
    drives = config.drives.of_actuators()
    assert [drive.position_gain_per_s for drive in drives] == [10.0, 5.0, 10.0, 10.0, 10.0]
    assert [drive.velocity_gain_nspm for drive in drives] == [8_000.0] * 3 + [9_000.0] * 2
    assert [drive.moving_mass_kg for drive in drives] == [3.0] * 3 + [5.0] * 2


def test_it_is_written_and_read_back() -> None:
    """Also with sections for single drives, and with push and pull apart."""
    config = parse_config(with_value("drives.telescopes.l3b.saturation_n", {"push": 100.0, "pull": 200.0}))
    assert Config.model_validate(config.model_dump(mode="json")) == config
    assert "l3b" in dump_config(config)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("drives.carts.kp", 3, "drives.carts.kp: is not a known key"),
        ("drives.carts.c4", {}, "drives.carts.c4: is not a known key"),
        ("drives.carts.l2b", {"delay_s": 0.0}, "drives.carts.l2b: is not a known key"),
        ("drives.telescopes.l2b.delay", 0.001, "drives.telescopes.l2b.delay: is not a known key"),
        ("drives.carts.feed_forward.velocity", 1.5, "is 1.5; allowed is a number from 0 to 1"),
        ("drives.carts.c1.integral_time_s", 0, "allowed is a number above 0, at most 1000 or null"),
        ("drives.telescopes.saturation_n", {"push": 1.0}, "drives.telescopes.saturation_n.pull: is missing"),
        ("drives.telescopes.encoder_step_m", -1e-6, "allowed is a number from 0 to 0.01"),
    ],
)
def test_what_is_wrong_is_named(path: str, value: object, message: str) -> None:
    """The key, the value and what is allowed."""
    assert message in messages(with_value(path, value))[0]


def test_gains_are_changed_in_the_keys_that_are_given() -> None:
    """What is set stays; the gains of all drives of a kind are set, whichever way the drives are given."""
    config = parse_config(with_value("drives.carts.c2.delay_s", 0.001, "drives.telescopes.encoder_step_m", 0.0))
    data = config.drives.with_gains({"position_gain_per_s": 4.0}, {"position_gain_per_s": 6.0})
    assert data["carts"]["c2"] == {"delay_s": 0.001, "position_gain_per_s": 4.0}
    assert data["telescopes"] == {"encoder_step_m": 0.0, "position_gain_per_s": 6.0}
    drives = parse_config({**AGDER, "drives": data}).drives.of_actuators()
    assert [drive.position_gain_per_s for drive in drives] == [4.0, 4.0, 4.0, 6.0, 6.0]
    assert drives[1].delay_s == 0.001
