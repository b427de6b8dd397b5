"""Fixtures of the proof: short paths with known answers."""

from tests.certify.conftest import *  # noqa: F403  # fixtures are found by their names here
