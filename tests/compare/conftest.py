"""Fixtures of the figures: a plausible route and two paths in one working mode."""

from tests.figures.conftest import *  # noqa: F403  # fixtures are found by their names here
