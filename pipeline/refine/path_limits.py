"""Limits of the configuration that more than one part of the program holds a path to."""

from collections.abc import Sequence

import numpy as np

from pipeline.config import Config
from pipeline.errors import ConfigError, ConfigIssue

TILTS = (("rx", 3), ("rz", 5))
"""The tilt axes, and where they stand in a pose."""


def kappa_cap(config: Config) -> float:
    """Cap on kappa along a path: the smaller of refine.kappa_max, where there is one, and route.kappa_max."""
    return min(config.refine.kappa_max or np.inf, config.route.kappa_max)


def tilt_limits_deg(config: Config) -> tuple[float, ...]:
    """Largest |rx| and |rz| along a path, in the order of `TILTS`: a locked axis has its tolerance."""
    task, tolerance = config.task, config.refine.lock_tolerance_deg
    return tuple(tolerance if axis in task.locked_axes else task.tilt_max_deg for axis, _ in TILTS)


def require_cap(config: Config, kappa: Sequence[float]) -> None:
    """Refuse a cap on the path's kappa that start or goal are above already; `kappa` is theirs.

    Raises
    ------
    ConfigError
        When refine.kappa_max is below one of them.
    """
    cap, ends = config.refine.kappa_max, max(kappa)
    if cap is not None and cap < ends:
        raise ConfigError(
            [ConfigIssue("refine.kappa_max", f"is {cap:g}; kappa at the start or the goal is {ends:.2f}")]
        )
