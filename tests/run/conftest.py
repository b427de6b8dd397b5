"""Fixtures of runs: a configuration that costs little, results that are made up, and fake stages."""

from collections.abc import Callable
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.config.file import parse_config
from tests.run.fake_stages import FakeStages
from tests.run.short_results import (
    make_certificate,
    make_path,
    make_refinement,
    make_regions,
    make_route,
    make_trajectory,
)


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run every command without the settings of whoever runs the tests."""
    for name in ("FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS", "NO_COLOR", "COLUMNS", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)


def changed(config: Config, **changes: Any) -> Config:
    """Change keys of a configuration, named by paths with two underscores for a dot."""
    data = config.model_dump(mode="json")
    for path, value in changes.items():
        *sections, key = path.split("__")
        part = data
        for section in sections:
            part = part[section]
        part[key] = value
    return parse_config(data)


@pytest.fixture(scope="session")
def change() -> Callable[..., Config]:
    """Give tests `changed`."""
    return changed


@pytest.fixture(scope="session")
def fast_config(quick_config: Config) -> Config:
    """Take few check points, so that measuring costs nothing."""
    return changed(quick_config, refine__check_points=1_000)


@pytest.fixture
def stages() -> FakeStages:
    """Make fake stages."""
    return FakeStages()


@pytest.fixture(scope="session")
def make() -> dict[str, Callable[..., Any]]:
    """Give tests the makers of results."""
    return {
        "regions": make_regions,
        "route": make_route,
        "refinement": make_refinement,
        "certificate": make_certificate,
        "trajectory": make_trajectory,
        "path": make_path,
    }
