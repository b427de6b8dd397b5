"""The bounds a certificate states, held against what its boxes prove, and against the limits of the configuration."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.endpoints import TOLERANCE
from pipeline.certify.limits import ROUNDING, SLIP, Limits, pair_name
from pipeline.certify.recheck.bounds import actuator_ranges, distance_bounds, end_misses, kappa_bounds, tilt_bounds
from pipeline.certify.recheck.claim import Claim
from pipeline.certify.recheck.inclusion import Boxes, Inclusions
from pipeline.certify.result import Bounds
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.refine.path_limits import TILTS
from pipeline.route.regions.endpoints import Endpoint

KAPPA = "kappa stays below its bound, within the cap"
SIGN = "det H keeps its sign"
DISTANCES = "axes keep their distances, as asked for"
ACTUATOR_RANGES = "carts and telescopes stay within bounds and limits"
TILT_RANGES = "tilts stay within bounds and limits"
ENDS = tuple(f"the {name} is the task's, its mode and branch too" for name in ("start", "goal"))
CLAIMS = (KAPPA, SIGN, DISTANCES, ACTUATOR_RANGES, TILT_RANGES, *ENDS)
"""All that is verified here."""

_BEYOND = ROUNDING + SLIP
"""Metres and radians that a stated bound may be beyond a limit."""
_ENDS = 1e-9
"""Metres and radians: how far two enclosures of an end may be apart."""


def bound_claims(machine: Machine, limits: Limits, bounds: Bounds, boxes: Boxes, found: Inclusions) -> Iterator[Claim]:
    """Verify what is stated of kappa, det H, distances, actuators and tilts, for every s."""
    kappa, sign = kappa_bounds(machine, boxes, found.image)
    worst = float(kappa.max())
    yield Claim(
        KAPPA,
        worst <= bounds.kappa <= limits.kappa_max,
        f"{worst:.6g}; stated {bounds.kappa:.6g}, cap {limits.kappa_max:.6g}",
    )
    keeps = bool((sign == bounds.det_sign).all()) and bounds.det_sign != 0
    yield Claim(SIGN, keeps, f"{', '.join(f'{one:+.0f}' for one in np.unique(sign))}; stated {bounds.det_sign:+d}")
    yield _distance_claim(machine, limits, bounds, boxes, found)
    actuators = actuator_ranges(boxes)
    yield Claim(
        ACTUATOR_RANGES,
        _inside(actuators, bounds.actuators_m)
        and _inside(bounds.actuators_m, limits.actuators_m + [-_BEYOND, _BEYOND]),
        "\n".join(
            f"{name} {_span(one)}, stated {_span(stated)}, limits {limit[0]:g} to {limit[1]:g} m"
            for name, one, stated, limit in zip(
                ACTUATORS, actuators, bounds.actuators_m, limits.actuators_m, strict=True
            )
        ),
    )
    tilt = tilt_bounds(boxes, found.image)
    degrees = (np.rad2deg(values) for values in (tilt, bounds.tilt_rad, limits.tilt_rad))
    yield Claim(
        TILT_RANGES,
        bool((tilt <= bounds.tilt_rad).all() and (bounds.tilt_rad <= limits.tilt_rad + _BEYOND).all()),
        "\n".join(
            f"{name} {one:.5g}, stated {stated:.5g}, limit {limit:.5g} degrees"
            for (name, _), one, stated, limit in zip(TILTS, *degrees, strict=True)
        ),
    )


def end_claims(
    machine: Machine, bounds: Bounds, joints: Boxes, met: Inclusions, ends: tuple[Endpoint, Endpoint]
) -> Iterator[Claim]:
    """Verify that the path begins and ends where the task does, as near as is stated."""
    misses, assembled = end_misses(machine, joints, met, ends)
    stated = (bounds.start_miss, bounds.goal_miss)
    for what, miss, most, right in zip(ENDS, misses, stated, assembled, strict=True):
        near = miss <= most + _ENDS and most <= TOLERANCE
        wrong = "" if right else "; another working mode or branch"
        yield Claim(what, near and right, f"off by {miss:.2g}; stated {most:.2g}, at most {TOLERANCE:.2g}{wrong}")


def _distance_claim(machine: Machine, limits: Limits, bounds: Bounds, boxes: Boxes, found: Inclusions) -> Claim:
    pairs, distances = distance_bounds(machine, boxes, found.image)
    least = distances.min(axis=1)
    names = tuple(pair_name(pairs, pair) for pair in range(len(least)))
    if names != bounds.pairs:
        missing = [name for name in names if name not in bounds.pairs]
        return Claim(
            DISTANCES, verified=False, found=f"other pairs are stated; missing: {', '.join(missing) or 'none'}"
        )
    if not names:
        return Claim(DISTANCES, verified=True, found="no pair is looked at")
    limit = np.array([limits.link_link_m] * len(pairs.links) + [limits.link_rail_m] * len(pairs.rails))
    kept = (least >= bounds.distances_m) & (bounds.distances_m >= limit)
    shown = int(np.argmin(least - limit) if kept.all() else np.argmin(kept))
    return Claim(
        DISTANCES,
        bool(kept.all()),
        f"{names[shown]} {least[shown]:.6g} m, stated {bounds.distances_m[shown]:.6g}, asked for {limit[shown]:g}",
    )


def _inside(ranges: FloatArray, of: FloatArray) -> bool:
    """Tell whether ranges (n, 2) lie within others."""
    return bool((ranges[:, 0] >= of[:, 0]).all() and (ranges[:, 1] <= of[:, 1]).all())


def _span(values: FloatArray) -> str:
    return f"{values[0]:.5g} to {values[1]:.5g}"
