"""What a user should know of a machine and its task before planning, although nothing is wrong."""

from collections.abc import Iterator

import numpy as np

from pipeline.config import Config
from pipeline.limits.actuator_margins import given_poses, given_positions_m, margins_m
from pipeline.limits.kappa import kappa_for_link_length
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.route.regions.endpoints import Endpoint

_LARGE_SHARE = 1.0 / 3.0
"""Part of the cap on kappa above which kappa at the start leaves little room."""


def machine_notes(config: Config, machine: Machine, start: Endpoint) -> list[str]:
    """State where the task leaves less than the configured margins, and a kappa that is large from the start."""
    return [*_narrow_margins(config, machine), *_large_kappa(config, machine, start)]


def _narrow_margins(config: Config, machine: Machine) -> Iterator[str]:
    for key, q in zip(given_poses(config), given_positions_m(config, machine), strict=True):
        left = np.minimum(q - machine.actuator_limits_m[:, 0], machine.actuator_limits_m[:, 1] - q)
        for k in np.flatnonzero(left < margins_m(config)[:, 0]):
            kind, what = ("travel", "rail") if k < 3 else ("stroke", "stroke")
            margin = 1e3 * margins_m(config)[k, 0]
            yield (
                f"Note: {key} has {ACTUATORS[k]} at {q[k]:.4f} m, {1e3 * left[k]:.3g} mm from the end of its {what}; "
                f"the path keeps that distance there instead of refine.{kind}_margin_m ({margin:.3g} mm)."
            )


def _large_kappa(config: Config, machine: Machine, start: Endpoint) -> Iterator[str]:
    """Advise the mean length of the links as the characteristic length, if that helps."""
    cap = config.route.kappa_max
    if start.kappa <= _LARGE_SHARE * cap:
        return
    length_m, kappa = kappa_for_link_length(start.samples)
    advice = (
        f"machine.characteristic_length_m is {machine.characteristic_length_m:g}; with {length_m:g}, the mean length "
        f"of the links, kappa would be {kappa:.3g} there"
        if kappa <= _LARGE_SHARE * cap
        else "raise route.kappa_max, or give the task a start farther from singularities"
    )
    yield (
        f"Warning: kappa at the start is {start.kappa:.3g}, more than a third of route.kappa_max ({cap:g}): that "
        f"leaves routes little room; {advice}."
    )
