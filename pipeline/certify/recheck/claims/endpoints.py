"""Both ends of the path: their poses, working modes and assembly branches are the task's.

What is stated of an end is compared with what is found, without slack: the search for the proof adds some to what it
states (`PROOF_SLACK`, `PROOF_MARGIN`), so that arithmetic with wider enclosures finds less than that.
"""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.endpoints import TOLERANCE
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, cross, dot, exactly, times, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions
from pipeline.certify.recheck.arithmetic.motion import along_rails
from pipeline.certify.recheck.arithmetic.norms import joint_shift
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, PRIMARY, TRIANGLE, Machine
from pipeline.route.regions.endpoints import Endpoint

CLAIMS: tuple[str, ...] = tuple(f"the {name} is the task's: its pose, mode and branch" for name in ("start", "goal"))


def endpoint_claims(
    machine: Machine, ends: tuple[Endpoint, Endpoint], joints: tuple[Boxes, Inclusions], stated: Bounds
) -> Iterator[Claim]:
    """Verify that the path begins and ends where the task does, as near as is stated: `joints` are its two ends."""
    misses = (stated.start_miss, stated.goal_miss)
    boxes, found = joints
    for k, (what, end, most) in enumerate(zip(CLAIMS, ends, misses, strict=True)):
        deviation = found.image[:, k]
        miss = float(total((exactly(boxes.pose[0][:, k]) - exactly(end.pose)).magnitude, deviation).max())
        right = bool(found.proven[k]) and _is_assembly(machine, end, boxes, deviation, k)
        near = miss <= most <= TOLERANCE
        wrong = "" if right else "; another working mode or branch"
        yield Claim(what, near and right, f"off by {miss:.2g}; stated {most:.2g}, at most {TOLERANCE:.2g}{wrong}")


def _is_assembly(machine: Machine, end: Endpoint, joints: Boxes, deviation: FloatArray, k: int) -> bool:
    """Return whether joint k is in the working mode of an end, and on the machine's assembly branch."""
    motion = joints.at
    shift, turn = joint_shift(machine, deviation), total(*deviation[3:])
    vectors = motion.vectors[0][..., k]
    along = along_rails(motion.vectors[0], motion.rails)[PRIMARY, k]
    # A hair more, for rails whose directions are rounded.
    along = Enclosure(along.mid, total(along.rad, times(shift[PRIMARY], np.array(1.0 + 1e-12))))
    modes = bool(((along * exactly(-MODE_SIGNS[end.mode])).lower > -1e-6).all())
    first = int(PRIMARY[ARM_OF_LINK[TRIANGLE]])
    arms = motion.arms[0][..., k]
    side = arms[TRIANGLE] - arms[first]
    leg = vectors[first] - (exactly(machine.cart_offsets_m[TRIANGLE]) - exactly(machine.cart_offsets_m[first]))
    moved = times(np.array(2.0), shift.max())
    side, leg = (Enclosure(part.mid, total(part.rad, moved)) for part in (side, leg))
    axis = motion.axes[0][1, :, k]
    axis = Enclosure(axis.mid, total(axis.rad, times(np.array(2.0), turn)))
    triangle = dot(axis, cross(side, leg, 0), 0) * exactly(machine.triangle_sign)
    return modes and bool(triangle.lower > 0.0)
