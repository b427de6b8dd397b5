"""Both ends of the path: the pose is the task's, in its working mode and on the machine's assembly branch."""

from flint import arb

from pipeline.certify.chain import Break
from pipeline.inclusion.closure import Geometry, closure, cross, dot
from pipeline.inclusion.condition import above
from pipeline.inclusion.krawczyk import Inclusion
from pipeline.inclusion.pieces import Piece
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, MODES, PRIMARY, TRIANGLE, Machine
from pipeline.route.regions.endpoints import Endpoint

TOLERANCE = 1e-6
"""Metres and radians by which an end may miss its pose."""


def check_end(
    machine: Machine, balls: Geometry, piece: Piece, joint: Inclusion, end: Endpoint, name: str
) -> tuple[float, Break | None]:
    """Bound how far the proven pose at an end is from the task's, and find out whether it is the right assembly."""
    s = joint.box.first
    pose = [arb(x) + arb(0, k.upper()) for x, k in zip(joint.box.pose[0].tolist(), joint.image, strict=True)]
    miss = max(above((x - arb(value)).abs_upper()) for x, value in zip(pose, end.pose.tolist(), strict=True))
    if not miss <= TOLERANCE:
        return miss, Break(s, f"the {name} is missed by {miss:.3g} (metres or radians)")
    found = closure(balls, pose, [arb(value[0]) for value in piece.taylor(s)])
    for arm, link in enumerate(PRIMARY.tolist()):
        towards = found.vectors[link][0] * -MODE_SIGNS[end.mode, arm]
        # At the serial singularity itself both modes are one pose.
        if not towards > -TOLERANCE:
            return miss, Break(s, f"at the {name} arm {arm + 1} is not in working mode {MODES[end.mode]}")
    first = int(PRIMARY[ARM_OF_LINK[TRIANGLE]])
    side = [c - a for c, a in zip(found.arms[TRIANGLE], found.arms[first], strict=True)]
    base = [c - a for c, a in zip(balls.anchors[TRIANGLE], balls.anchors[first], strict=True)]
    leg = [v - d for v, d in zip(found.vectors[first], base, strict=True)]
    if not dot(found.axes[1], cross(side, leg)) * machine.triangle_sign > 0:
        return miss, Break(s, f"at the {name} the triangle is not assembled as triangle_branch says")
    return miss, None
