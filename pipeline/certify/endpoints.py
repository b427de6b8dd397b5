"""Both ends of the path: the pose is the task's, in its working mode and on the machine's assembly branch."""

from collections.abc import Sequence

from flint import arb

from pipeline.certify.problem import ProofProblem
from pipeline.certify.reasons import ProofFailure, Reason
from pipeline.inclusion.closure import Closure, Geometry, closure, cross, dot
from pipeline.inclusion.condition import above
from pipeline.inclusion.krawczyk import Inclusion
from pipeline.machine.geometry import ARM_OF_LINK, MODE_SIGNS, MODES, PRIMARY, TRIANGLE
from pipeline.route.regions.endpoints import Endpoint

TOLERANCE = 1e-6
"""Metres and radians by which an end may miss its pose."""
PROOF_SLACK, PROOF_MARGIN = 1e-10, 0.01
"""What the misses are enlarged by, and relatively, so that other arithmetic with wider enclosures can verify them."""


def check_ends(
    problem: ProofProblem, joints: Sequence[Inclusion], ends: tuple[Endpoint, Endpoint]
) -> tuple[tuple[float, float], ProofFailure | None]:
    """Bound how far the proven poses at both ends are from the task's, and check that each is assembled as it should.

    Returns
    -------
    misses : (float, float)
        In metres or radians, whichever is larger.
    failure : ProofFailure or None
        The first end that is not the task's.
    """
    start_miss, start = _check_end(problem, joints[0], ends[0], at_goal=False)
    goal_miss, goal = _check_end(problem, joints[-1], ends[1], at_goal=True)
    return (start_miss, goal_miss), start or goal


def _check_end(
    problem: ProofProblem, joint: Inclusion, end: Endpoint, at_goal: bool
) -> tuple[float, ProofFailure | None]:
    name, piece, s = ("goal" if at_goal else "start"), problem.pieces[-1 if at_goal else 0], joint.box.first
    pose = [arb(x) + arb(0, k.upper()) for x, k in zip(joint.box.pose[0].tolist(), joint.image, strict=True)]
    off = max(above((x - arb(value)).abs_upper()) for x, value in zip(pose, end.pose.tolist(), strict=True))
    miss = (1.0 + PROOF_MARGIN) * off + PROOF_SLACK
    if not miss <= TOLERANCE:
        return miss, ProofFailure(s, Reason(f"the {name} is missed by {miss:.3g} (metres or radians)"))
    found = closure(problem.balls, pose, [arb(value[0]) for value in piece.taylor(s)])
    along = found.along_rails()
    for arm, link in enumerate(PRIMARY.tolist()):
        towards = along[link] * -MODE_SIGNS[end.mode, arm]
        # At the serial singularity itself both modes are one pose.
        if not towards > -TOLERANCE:
            return miss, ProofFailure(
                s, Reason(f"at the {name} arm {arm + 1} is not in working mode {MODES[end.mode]}")
            )
    if not _triangle_orientation(problem.balls, found) * problem.machine.triangle_sign > 0:
        return miss, ProofFailure(s, Reason(f"at the {name} the triangle is not assembled as triangle_branch says"))
    return miss, None


def _triangle_orientation(balls: Geometry, found: Closure[arb]) -> arb:
    """Compute y_platform . (side x leg) of the triangle, whose sign is its assembly branch."""
    first = int(PRIMARY[ARM_OF_LINK[TRIANGLE]])
    side = [c - a for c, a in zip(found.arms[TRIANGLE], found.arms[first], strict=True)]
    base = [c - a for c, a in zip(balls.anchors[TRIANGLE], balls.anchors[first], strict=True)]
    leg = [v - d for v, d in zip(found.vectors[first], base, strict=True)]
    return dot(found.axes[1], cross(side, leg))
