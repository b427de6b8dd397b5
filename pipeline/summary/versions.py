"""Versions of the package and of the libraries it computes with."""

import functools
import platform
from importlib import metadata

PACKAGE = "gantry-tau"
_LIBRARIES = ("numpy", "scipy", "highspy", "casadi", "python-flint", "matplotlib", "plotly")


@functools.cache
def package_version() -> str:
    """Give the version of the installed package."""
    return metadata.version(PACKAGE)


@functools.cache
def versions() -> dict[str, str]:
    """Give the versions of everything the results depend on."""
    known = {name: metadata.version(name) for name in (PACKAGE, *_LIBRARIES)}
    return {**known, "python": platform.python_version()}
