"""Tests that search for input on which a reader fails: a few cases each time, and as many as one likes.

`make fuzz` runs these alone, with a hundred times the cases, and shows how many were tried.
"""

import os
from collections.abc import Callable
from typing import Any, TypeVar

import pytest
from hypothesis import HealthCheck, settings

_Test = TypeVar("_Test", bound=Callable[..., Any])
FACTOR = int(os.environ.get("FUZZ", "1"))
"""How many times the usual number of cases are tried."""


def fuzz(cases: int) -> Callable[[_Test], _Test]:
    """Mark a test of random input, and say how many cases it usually tries."""
    options = settings(
        max_examples=FACTOR * cases,
        deadline=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )
    return lambda test: pytest.mark.fuzz(options(test))
