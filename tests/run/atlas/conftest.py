"""A task of three stations that costs next to nothing."""

import pytest

from pipeline.config import Config
from pipeline.config.file import load_config
from tests.conftest import CONFIGS
from tests.run.conftest import *  # noqa: F403  # fixtures are found by their names here

LEFT = {"name": "left", "pose": {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "mode": "LLL"}}
RIGHT = {"name": "right", "pose": {"x_m": 1.02, "y_m": 0.3, "z_m": 0.9, "mode": "RRR"}}
LOW = {"name": "low", "pose": {"x_m": 1.02, "y_m": 0.45, "z_m": 0.6, "mode": "LLL"}}


@pytest.fixture(scope="session")
def cell(vary) -> Config:
    """Give the task of tiny.yaml with two stations on the left and one on the right."""
    return vary(load_config(CONFIGS / "tiny.yaml"), {"atlas.stations": [LEFT, RIGHT, LOW]})
