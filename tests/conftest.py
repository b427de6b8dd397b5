"""Fixtures shared by all tests, and how hypothesis searches."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from functools import reduce
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.machine import Machine, build_machine

CONFIGS = Path(__file__).parents[1] / "configs"

# Examples are fixed on a build server: a failure there must come from the change, never from luck.
settings.register_profile("local", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("local"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")


@pytest.fixture(scope="session", autouse=True)
def _interruptible() -> Iterator[None]:
    """Let Ctrl-C be what it is, even where the tests run in the background of a script, which ignores it."""
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if not ignored or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.fixture(scope="session")
def agder_config() -> Config:
    """Load the reference machine and task."""
    return load_config(CONFIGS / "agder.yaml")


@pytest.fixture(scope="session")
def quick_config() -> Config:
    """Load the reference machine on a coarse grid."""
    return load_config(CONFIGS / "quick.yaml")


@pytest.fixture(scope="session")
def machine(agder_config: Config) -> Machine:
    """Build the reference machine."""
    return build_machine(agder_config.machine)


@pytest.fixture(scope="session")
def vary() -> Callable[[Config, dict[str, object]], Config]:
    """Give a function that sets keys, written with dots, in a copy of a configuration."""

    def change(config: Config, values: dict[str, object]) -> Config:
        data = config.model_dump()
        for path, value in values.items():
            *sections, key = path.split(".")
            reduce(lambda part, name: part[int(name) if name.isdigit() else name], sections, data)[key] = value
        return parse_config(data)

    return change
