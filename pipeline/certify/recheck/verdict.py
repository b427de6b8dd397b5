"""A stored certificate held against its path and machine: which of its claims are verified, and which are not."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.certify.limits import ROUNDING, SLIP, Limits, pair_name
from pipeline.certify.recheck.bounds import actuator_ranges, distance_bounds, end_misses, kappa_bounds, tilt_bounds
from pipeline.certify.recheck.inclusion import Boxes, Inclusions, build_boxes, holds, include
from pipeline.certify.result import Bounds, ProvenChain, path_sha256
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path
from pipeline.route.ends import End

_ENDS = 1e-9
"""Metres and radians: how far two enclosures of an end may be apart."""


@dataclass(frozen=True)
class Claim:
    """A claim of a certificate: what it says, whether it was verified, and what was found."""

    what: str
    verified: bool
    found: str


def verify(
    machine: Machine,
    path: Path,
    limits: Limits,
    ends: tuple[End, End],
    sha256: str,
    bounds: Bounds,
    chains: list[ProvenChain],
) -> list[Claim]:
    """Verify every claim of a certificate, without searching for anything."""
    claims = [Claim("it speaks of this path", sha256 == path_sha256(path), path_sha256(path))]
    # Numbers that are none compare as false: what cannot be computed is not verified.
    with np.errstate(all="ignore"):
        for number, chain in enumerate(chains):
            try:
                boxes, found, joints, met = _include(machine, path, chain)
                claims += _chain_claims(chain, boxes, found, joints, met)
                if number == 0:
                    claims += [
                        Claim("the first chain is of the machine as configured", not chain.uncertainty.any, ""),
                        *_bound_claims(machine, limits, bounds, boxes, found),
                        *_end_claims(machine, bounds, joints, met, ends),
                    ]
            except (np.linalg.LinAlgError, ValueError) as error:
                claims.append(Claim(f"chain {number + 1} can be computed", verified=False, found=str(error)))
    return claims


def _include(machine: Machine, path: Path, chain: ProvenChain) -> tuple[Boxes, Inclusions, Boxes, Inclusions]:
    boxes = build_boxes(machine, path, chain.boxes)
    joints = build_boxes(machine, path, chain.joints)
    return boxes, include(machine, boxes, chain.uncertainty), joints, include(machine, joints, chain.uncertainty)


def _chain_claims(
    chain: ProvenChain, boxes: Boxes, found: Inclusions, joints: Boxes, met: Inclusions
) -> Iterator[Claim]:
    uncertainty, n = chain.uncertainty, len(boxes.first)
    of = "the machine as configured"
    if uncertainty.any:
        of = f"lengths within {1e3 * uncertainty.length_m:.4g} mm, coordinates {1e3 * uncertainty.coordinate_m:.4g} mm"
    whole = boxes.first[0] == 0.0 and boxes.last[-1] == 1.0 and bool((boxes.first[1:] == boxes.last[:-1]).all())
    within = bool((boxes.first < boxes.last).all())
    yield Claim(f"{of}: boxes reach from s = 0 to s = 1", whole and within, f"{n} boxes")
    yield Claim(
        f"{of}: each holds one pose, and is regular", bool(found.proven.all()), f"{int(found.proven.sum())} of {n}"
    )
    ends = np.append(boxes.first, boxes.last[-1])
    single = bool((joints.first == joints.last).all()) and np.array_equal(joints.first, ends)
    linked = holds(boxes, found, joints, met, at_end=False) & holds(boxes, found, joints, met, at_end=True)
    linked &= met.proven[1:] & met.proven[:-1]
    yield Claim(f"{of}: neighbours hold the same branch", single and bool(linked.all()), f"{int(linked.sum())} of {n}")


def _bound_claims(machine: Machine, limits: Limits, bounds: Bounds, boxes: Boxes, found: Inclusions) -> Iterator[Claim]:
    kappa, sign = kappa_bounds(machine, boxes, found.image)
    worst = float(kappa.max())
    yield Claim("kappa stays below its bound", worst <= min(bounds.kappa, limits.kappa_max), f"{worst:.6g}")
    yield Claim(
        "det H keeps its sign", bool((sign == bounds.det_sign).all() and bounds.det_sign), f"{bounds.det_sign:+d}"
    )
    pairs, distances = distance_bounds(machine, boxes, found.image)
    least = distances.min(axis=1)
    limit = np.array([limits.link_link_m] * len(pairs.links) + [limits.link_rail_m] * len(pairs.rails))
    names = tuple(pair_name(pairs, pair) for pair in range(len(least)))
    kept = names == bounds.pairs and bool((least >= np.maximum(bounds.distances_m, limit)).all())
    yield Claim("axes keep their distances", kept, f"{least.min(initial=np.inf):.6g} m")
    actuators, tilt = actuator_ranges(boxes), tilt_bounds(boxes, found.image)
    low = np.maximum(bounds.actuators_m[:, 0], limits.actuators_m[:, 0] - ROUNDING - SLIP)
    high = np.minimum(bounds.actuators_m[:, 1], limits.actuators_m[:, 1] + ROUNDING + SLIP)
    within = bool((actuators[:, 0] >= low).all() and (actuators[:, 1] <= high).all())
    yield Claim(
        "carts and telescopes stay within their bounds", within, f"{actuators.min():.6g} to {actuators.max():.6g} m"
    )
    tilted = bool((tilt <= np.minimum(bounds.tilt_rad, limits.tilt_rad + ROUNDING + SLIP)).all())
    yield Claim("tilts stay within their bounds", tilted, f"{np.rad2deg(tilt.max()):.6g} degrees")


def _end_claims(
    machine: Machine, bounds: Bounds, joints: Boxes, met: Inclusions, ends: tuple[End, End]
) -> Iterator[Claim]:
    misses, assembled = end_misses(machine, joints, met, ends)
    claimed = (bounds.start_miss, bounds.goal_miss)
    for name, miss, most, right in zip(("start", "goal"), misses, claimed, assembled, strict=True):
        near = miss <= most + _ENDS and miss <= ROUNDING
        yield Claim(f"the {name} is the task's, in its working mode and branch", near and right, f"off by {miss:.2g}")
