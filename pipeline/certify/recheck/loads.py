"""The check of loads in motion: forces of drives and links, and the TCP's speed and acceleration, by other code.

As the check of a time law, it shares nothing with the proof but the numbers of path, law and machine.
"""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import PPoly

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.loads.load_use import largest_loads
from pipeline.certify.recheck.arithmetic.loads.path_loads import path_loads
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.time_law import StatedMotion, within_limits
from pipeline.errors import ForwardKinematicsError
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path

ON_BRANCH = "loads are those of the poses that continue the path's first one"
LOADS = ("force", "link_force", "tcp_speed", "tcp_acceleration")
_COLUMNS = (slice(0, 5), slice(5, 11), slice(11, 12), slice(12, 13))


def verify_loads(path: Path, law: PPoly, stated: StatedMotion) -> Iterator[Claim]:
    """Verify the loads that are limited, or stated in SI units, at every instant of a law along a path."""
    machine = path.machine
    limits = _limits(machine)
    asked = {
        name: columns
        for name, columns in zip(LOADS, _COLUMNS, strict=True)
        if name in stated.peaks or name in stated.fractions or np.isfinite(limits[:, columns]).any()
    }
    if not asked:
        return
    enough, allowed = np.full_like(limits, np.inf), dict[str, bool]()
    for name, columns in asked.items():
        limit, width = limits[:, columns], columns.stop - columns.start
        part = stated.fractions.get(name, np.full(width, 0.0 if np.isinf(limit).all() else np.inf))
        peak = stated.peaks.get(name, np.full(width, np.inf))
        allowed[name] = len(part) == width == len(peak) and bool((part <= 1.0).all())
        if allowed[name]:
            within = part * np.where(np.isfinite(limit), limit, 0.0)
            enough[:, columns] = np.minimum(np.where(np.isfinite(limit), within, np.inf), peak)
    try:
        # NaN compares as false: what cannot be computed is not verified.
        with np.errstate(all="ignore"):
            loads = path_loads(path)
            friction = np.zeros(5) if machine.masses is None else machine.masses.friction_n
            found = largest_loads(loads, law, friction, enough * (1.0 - 1e-12))
    except (ForwardKinematicsError, np.linalg.LinAlgError, ValueError, OverflowError):
        text = "there is no pose, some numbers are too large, or matrices have no inverse"
        yield Claim(ON_BRANCH, verified=False, found=text)
        return
    yield Claim(ON_BRANCH, loads.proven, f"{len(loads.first)} boxes")
    for name, columns in asked.items():
        holds = loads.proven and allowed[name] and bool((found[:, columns] <= enough[:, columns]).all())
        yield Claim(within_limits(name.replace("_", " ").replace("tcp", "TCP")), holds, _words(found, enough, columns))


def _limits(machine: Machine) -> FloatArray:
    """Give the limits of positive and of negative values, (2, 13); infinite where there is none."""
    forces = machine.force_limits_n if machine.masses is not None else np.full((2, 11), np.inf)
    return np.column_stack(
        [forces, *(np.full(2, one) for one in (machine.tcp_speed_mps, machine.tcp_acceleration_mps2))]
    )


def _words(found: FloatArray, enough: FloatArray, columns: slice) -> str:
    with np.errstate(all="ignore"):
        share = np.nan_to_num(found[:, columns] / enough[:, columns], nan=np.inf)
    return f"{share.max():.4g} of what is stated"
