"""Both ends of the path: their poses, working modes and assembly branches are the task's."""

from collections.abc import Iterator

import numpy as np

from pipeline.certify.bounds import Bounds
from pipeline.certify.endpoints import TOLERANCE
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, cross, dot, exactly, total
from pipeline.certify.recheck.arithmetic.norms import joint_shift
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, PRIMARY, TRIANGLE
from pipeline.route.regions.endpoints import Endpoint

CLAIMS: tuple[str, ...] = tuple(f"the {name} is the task's: its pose, mode and branch" for name in ("start", "goal"))
KEYS: tuple[str, ...] = ()

_ROUNDING = 1e-9
"""Metres and radians by which two enclosures of an end may differ."""


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify that the path begins and ends where the task does, as near as is stated."""
    misses = (stated.start_miss, stated.goal_miss)
    for what, end, k, most in zip(CLAIMS, evidence.ends, (0, -1), misses, strict=True):
        miss, right = _miss(evidence, end, k), _is_assembly(evidence, end, k)
        near = miss <= most + _ROUNDING and most <= TOLERANCE
        wrong = "" if right else "; another working mode or branch"
        yield Claim(what, near and right, f"off by {miss:.2g}; stated {most:.2g}, at most {TOLERANCE:.2g}{wrong}")


def _miss(evidence: Evidence, end: Endpoint, k: int) -> float:
    """Bound how far joint k is from the pose of an end, in metres or radians."""
    away = exactly(evidence.chain.joints.pose[0][:, k]) - exactly(end.pose)
    return float(total(away.magnitude, evidence.chain.joint_inclusions.image[:, k]).max())


def _is_assembly(evidence: Evidence, end: Endpoint, k: int) -> bool:
    """Return whether joint k is in the working mode of an end, and on the machine's assembly branch."""
    machine, motion, deviation = evidence.machine, evidence.chain.joints.at, evidence.chain.joint_inclusions.image[:, k]
    shift, turn = joint_shift(machine, deviation), total(*deviation[3:])
    vectors = motion.vectors[0][..., k]
    x = Enclosure(vectors.mid[PRIMARY, 0], vectors.rad[PRIMARY, 0] + shift[PRIMARY])
    modes = bool(((x * exactly(-MODE_SIGNS[end.mode])).lower > -1e-6).all())
    first = int(PRIMARY[ARM_OF_LINK[TRIANGLE]])
    arms = motion.arms[0][..., k]
    side = arms[TRIANGLE] - arms[first]
    base = machine.cart_offsets_m[TRIANGLE] - machine.cart_offsets_m[first]
    leg = vectors[first] - Enclosure(base, np.abs(base) * 1e-15)
    side, leg = (Enclosure(part.mid, part.rad + 2.0 * shift.max() + 1e-15) for part in (side, leg))
    axis = motion.axes[0][1, :, k]
    axis = Enclosure(axis.mid, axis.rad + 2.0 * turn)
    triangle = dot(axis, cross(side, leg, 0), 0) * exactly(machine.triangle_sign)
    return modes and bool(triangle.lower > 0.0)
