"""What chains of following errors claim beside one pose: limits of kappa and axes, and reserves of tilts."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import times, total
from pipeline.certify.recheck.claims import kappa
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.distances import axis_distances
from pipeline.certify.recheck.claims.evidence import combined
from pipeline.config import Config
from pipeline.limits.kappa import path_cap
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS

WITHIN_LIMITS = "kappa and distances of axes stay within their limits"
RESERVE = "rx and rz are off the path by no more than stated"

Evidence = tuple[FloatArray, FloatArray]
"""Bounds of kappa and det H, and of distances, over some boxes."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain, before: Evidence | None) -> Evidence:
    """Bound kappa and distances over a segment of boxes as well as over those before it, for all errors."""
    found = kappa.measure(config, machine, segment), axis_distances.measure(config, machine, segment)
    return found if before is None else (combined(before[0], found[0]), combined(before[1], found[1]))


def limit_claim(of: str, config: Config, machine: Machine, found: Evidence) -> Claim:
    """Verify that limits of kappa and distances are kept for all errors, and det H has one sign."""
    (_, largest), signs = found[0].tolist()
    cap, required = path_cap(config), axis_distances.required_m(machine)
    short = found[1][:, 0] - required
    kept = largest <= cap and signs[0] == signs[1] != 0.0 and bool((short >= 0.0).all())
    nearest = f", nearest axes {found[1][int(np.argmin(short)), 0]:.5g} m" if len(short) else ""
    return Claim(f"{of}: {WITHIN_LIMITS}", kept, f"kappa {largest:.5g}, cap {cap:g}{nearest}")


def tilts_off_deg(segment: EvaluatedChain) -> FloatArray:
    """Bound how far rx and rz are off the path for all errors, over some boxes: |P| A + 2 k. Shape (2,), degrees."""
    following, image = segment.inclusions.following, segment.inclusions.image[TILT_COLUMNS]
    moved = np.zeros_like(image) if following is None else following.moved[TILT_COLUMNS]
    # The float nearest to pi is below it: this factor is above the exact one.
    return times(total(moved, image, image).max(axis=1), total(np.array(180.0 / np.pi)))


def reserve_claims(of: str, found_deg: FloatArray, stated_deg: tuple[float, float] | None) -> Iterator[Claim]:
    """Verify a stated reserve, if there is one."""
    if stated_deg is not None:
        text = "; ".join(f"{one:.4g}, stated {most:.4g}" for one, most in zip(found_deg, stated_deg, strict=True))
        yield Claim(f"{of}: {RESERVE}", bool((found_deg <= np.array(stated_deg)).all()), f"{text} degrees")
