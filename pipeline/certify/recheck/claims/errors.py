"""What chains of following errors claim beside one pose: limits that are kept, and reserves of tilts."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import times, total
from pipeline.certify.recheck.claims import kappa
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.controlled import avoided
from pipeline.certify.recheck.claims.distances import axis_distances, body_distances
from pipeline.certify.recheck.claims.evidence import combined
from pipeline.certify.recheck.claims.joints import angles
from pipeline.config import Config
from pipeline.limits.kappa import path_cap
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_COLUMNS

WITHIN_LIMITS = "kappa, distances, joint angles and boxes to avoid keep their limits"
RESERVE = "rx and rz are off the path by no more than stated"

_KEPT = (kappa, axis_distances, body_distances, angles, avoided)
Evidence = tuple[FloatArray, ...]
"""What each of these bounds over some boxes: kappa and det H, distances of axes, of bodies, joint angles, boxes to
avoid."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain, before: Evidence | None) -> Evidence:
    """Bound everything that is kept over a segment of boxes as well as over those before it, for all errors."""
    found = tuple(limit.measure(config, machine, segment) for limit in _KEPT)
    return found if before is None else tuple(combined(*pair) for pair in zip(before, found, strict=True))


def limit_claim(of: str, config: Config, machine: Machine, found: Evidence) -> Claim:
    """Verify that the limits of kappa, distances, joints and boxes are kept for all errors, and det H has one sign."""
    (_, largest), signs = found[0].tolist()
    cap = path_cap(config)
    room = {
        "axes, m": found[1][:, 0] - axis_distances.required_m(machine),
        "bodies, m": found[2][:, 0] - body_distances.required_m(config, machine),
        "joints, degrees": np.array([cone.half_angle_deg for cone in machine.joint_cones]) - found[3][:, 1],
        "boxes to avoid, m or rad": found[4][:, 0] - avoided.LEAST,
    }
    kept = largest <= cap and signs[0] == signs[1] != 0.0 and all((left >= 0.0).all() for left in room.values())
    left = "".join(f"; room of {what}: {left.min():.4g}" for what, left in room.items() if len(left))
    return Claim(f"{of}: {WITHIN_LIMITS}", bool(kept), f"kappa {largest:.5g}, cap {cap:g}{left}")


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
