"""The section `atlas`."""

import pytest

from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.errors import ConfigError

POSE = {"x_m": 1.02, "y_m": 0.45, "z_m": 0.6, "mode": "LLL"}
TWO = [{"name": "a", "pose": POSE}, {"name": "b", "pose": POSE}]


@pytest.mark.parametrize(
    ("stations", "key", "words"),
    [
        (TWO[:1], "atlas.stations", "at least two"),
        ([TWO[0], TWO[0]], "atlas.stations", "has a more than once"),
        ([TWO[0], {"name": "a--b", "pose": POSE}], "atlas.stations[1].name", "joined by '-'"),
        ([TWO[0], {"name": "../b", "pose": POSE}], "atlas.stations[1].name", "letters"),
        ([TWO[0], {"name": "b", "pose": POSE | {"rz_deg": 40.0}}], "atlas.stations[1].pose.rz_deg", "tilt_max_deg"),
        ([TWO[0], {"name": "b"}], "atlas.stations[1].pose", "is missing"),
    ],
)
def test_faults_are_named(quick_config: Config, vary, stations: list, key: str, words: str) -> None:
    """The key that has to change, and what is allowed there."""
    with pytest.raises(ConfigError) as caught:
        vary(quick_config, {"atlas.stations": stations})
    assert [issue.path for issue in caught.value.issues] == [key]
    assert words in caught.value.issues[0].message


def test_stations_do_not_count_in_the_hash_of_a_run(quick_config: Config, vary) -> None:
    """No run reads them, so that none is outdated by them."""
    assert config_sha256(vary(quick_config, {"atlas.stations": TWO})) == config_sha256(quick_config)
