"""Cones of joints in the configuration."""

from collections.abc import Callable

import pytest

from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config, load_config, parse_config
from pipeline.errors import ConfigError
from tests.joints import CONES


@pytest.mark.parametrize(
    ("cone", "message"),
    [
        ({"axis": [0, 0, 0], "half_angle_deg": 40}, "platform_cone.axis: is [0, 0, 0]; allowed is any other direction"),
        (
            {"axis": [0, 1], "half_angle_deg": 40},
            "platform_cone.axis[2]: is missing; allowed is a number from -20 to 20",
        ),
        (
            {"axis": [0, 0, 1], "half_angle_deg": 0},
            "platform_cone.half_angle_deg: is 0; allowed is a number above 0, less than 180",
        ),
        ({"axis": [0, 0, 1], "half_angle_deg": 180}, "platform_cone.half_angle_deg: is 180; allowed is a number"),
        ({"axis": [0, 0, 1], "half_angle_deg": -5}, "platform_cone.half_angle_deg: is -5; allowed is a number"),
        ({"axis": [0, 0, 1]}, "platform_cone.half_angle_deg: is missing; allowed is a number above 0, less than 180"),
        ({"half_angle_deg": 40}, "platform_cone.axis: is missing; allowed is a list of 3 numbers"),
        ({"axis": [0, 0, 1], "angle_deg": 40, "half_angle_deg": 40}, "platform_cone.angle_deg: is not a known key"),
        (40.0, "platform_cone: is 40.0; allowed is a section with the keys axis, half_angle_deg or null"),
    ],
)
@pytest.mark.parametrize("link", ["l1", "l2b", "l3c"])
def test_a_wrong_cone_is_refused_with_its_key(agder_config: Config, link: str, cone: object, message: str) -> None:
    """Of every sort of link."""
    data = agder_config.model_dump()
    data["machine"]["links"][link]["platform_cone"] = cone
    with pytest.raises(ConfigError) as error:
        parse_config(data)
    assert f"machine.links.{link}.{message}" in str(error.value)


def test_configurations_without_cones_stay_as_they_are(agder_config: Config) -> None:
    """Their files and hashes know nothing of cones."""
    assert "cone" not in dump_config(agder_config)
    data = agder_config.model_dump()
    data["machine"]["links"]["l1"] |= {"cart_cone": None, "platform_cone": None}
    assert config_sha256(parse_config(data)) == config_sha256(agder_config)


def test_cones_are_written_and_read(agder_config: Config, vary: Callable, tmp_path) -> None:
    """Every number of them counts."""
    config = vary(agder_config, CONES)
    file = tmp_path / "config.yaml"
    file.write_text(dump_config(config))
    assert load_config(file) == config
    for place, value in (("half_angle_deg", 104.0), ("axis", [0.0, 0.98, -0.14])):
        other = vary(config, {f"machine.links.l2b.platform_cone.{place}": value})
        assert config_sha256(other) != config_sha256(config)
