"""Fixtures of the second process: those of runs."""

from tests.run.conftest import *  # noqa: F403  # fixtures are found by their names here
