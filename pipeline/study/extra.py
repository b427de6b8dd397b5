"""Libraries that studies alone need, and that are installed on request."""

from importlib import import_module
from typing import Any

from pipeline.errors import UsageError


def library(name: str) -> Any:
    """Import a library when it is used.

    Raises
    ------
    UsageError
        When it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise UsageError(
            f"studies need the library {error.name}, which is not installed: pip install 'gantry-tau[study]'"
        ) from None
