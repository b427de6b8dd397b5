"""The chain of boxes from s = 0 to s = 1: a box that cannot be proven is halved, until the chain closes or breaks.

Each box holds exactly one solution at every s of its interval. At the single s that two neighbours share, a third box
is proven, and the solution it holds is within its *image* (`Inclusion`), which is smaller than the box. If the image
lies within both neighbours, that solution is theirs, too, and both are on one branch. The third box itself may reach
beyond them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import cast

from flint import arb, arb_poly

from pipeline.arrays import FloatArray
from pipeline.certify.problem import ProofProblem, prove_box
from pipeline.certify.reasons import (
    ACTUATORS_JUMP,
    JUMP,
    NO_INCLUSION,
    SPLINES_INCOMPLETE,
    ProofFailure,
    Reason,
)
from pipeline.inclusion.krawczyk import SLACK, Box, Inclusion, Piecewise
from pipeline.inclusion.matrices import added, ball_matrix, magnitudes, times, upper_vector
from pipeline.inclusion.pieces import Piece, exact, middle
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.progress import QUIET, Monitor

_INFLATION, _NARROW = 1.08, 0.3
"""How much larger than what they have to hold radii are at least; narrower parts of a piece may be undecided at a
single s."""
MOST_BOXES = 100_000
"""Most boxes of a chain, so that a certificate can be kept, read and verified."""
TOO_MANY_BOXES = Reason(
    f"the proof would take more than {MOST_BOXES:,} boxes",
    "Raise certify.kappa_excess, or give the path a wider berth: lower refine.kappa_max.",
)
BoxBounds = tuple[FloatArray, ...]
"""Bounds over one box: per limit an array (m, 2)."""
Examiner = Callable[[ProvenBox], BoxBounds | Reason]
"""Bounds the limits over a proven box, or gives the reason why the box is not good enough."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Proven boxes in order.

    Attributes
    ----------
    inclusions, bounds : n
        The boxes, and the bounds over each.
    joints : n + 1
        Inclusions at a single s: the ends of the boxes.
    failure : ProofFailure or None
        Where and why the chain ends; None if it reaches s = 1.
    """

    inclusions: tuple[Inclusion, ...]
    bounds: tuple[BoxBounds, ...]
    joints: tuple[Inclusion, ...]
    failure: ProofFailure | None


@dataclass(frozen=True, eq=False)
class _Link:
    """A proven box, the bounds over it, and the pose at its end."""

    inclusion: Inclusion
    bounds: BoxBounds
    joint: Inclusion


def accept_any(box: ProvenBox) -> BoxBounds:
    """Accept any proven box, without bounds."""
    return ()


def close_chain(problem: ProofProblem, examine: Examiner = accept_any, monitor: Monitor = QUIET) -> Chain:
    """Prove boxes from s = 0 on until the chain reaches s = 1, or an interval fails that is too narrow to be halved."""
    if (fault := _discontinuity(problem.pieces)) is not None:
        return Chain((), (), (), fault)
    return close_over(problem, problem.pieces, examine, monitor)


def close_over(
    problem: ProofProblem, pieces: Sequence[Piece], examine: Examiner = accept_any, monitor: Monitor = QUIET
) -> Chain:
    """Prove boxes over neighbouring pieces of a continuous path.

    With a memory, what failed for smaller errors is halved unseen, what was proven for larger ones is kept, and what
    fails at a single s is given up at once.
    """
    origin = pieces[0]
    start = prove_joint(problem, origin, origin.first)
    if isinstance(start, Reason):
        return Chain((), (), (), ProofFailure(origin.first, start))
    links: list[_Link] = []
    for piece in pieces:
        waiting = [(piece.first, piece.last)]
        while waiting:
            first, last = waiting.pop()
            before = links[-1].joint if links else start
            link = _try_link(problem, piece, (first, last), before, examine)
            if isinstance(link, _Link):
                if len(links) == MOST_BOXES:
                    return _chain(start, links, ProofFailure(first, TOO_MANY_BOXES))
                links.append(link)
                monitor.progress(f"{len(links)} boxes", last)
                continue
            centre, _ = middle(first, last)
            failure = link if last - first < 2.0 * problem.least_width else None
            if problem.memory is not None and last - first < _NARROW * (piece.last - piece.first):
                failure = what_fails_at(problem, piece, centre, examine) or failure
            if failure is not None:
                return _chain(start, links, ProofFailure(centre, failure))
            waiting += [(centre, last), (first, centre)]
    return _chain(start, links, None)


def _try_link(
    problem: ProofProblem, piece: Piece, interval: tuple[float, float], before: Inclusion, examine: Examiner
) -> _Link | Reason:
    """Prove a link, or give the reason why it failed, for these errors or smaller ones."""
    memory, key = problem.memory, (piece.first, *interval)
    if memory is None:
        return _prove_link(problem, piece, interval, before, examine)
    errors = problem.errors_over(piece).largest_m
    failed_m, reason = memory.failed.get(key, (inf, NO_INCLUSION))
    if errors >= failed_m:
        return reason
    proven_m, kept = memory.proven.get(key, (-inf, None))
    if errors <= proven_m and holds(kept.inclusion, before):
        return cast("_Link", kept)
    link = _prove_link(problem, piece, interval, before, examine)
    if isinstance(link, Reason):
        memory.failed[key] = errors, link
    else:
        memory.proven[key] = errors, link
    return link


def what_fails_at(problem: ProofProblem, piece: Piece, s: float, examine: Examiner) -> Reason | None:
    """Say why no box can be proven at a single s, with its bounds: then none around it can. None if one can."""
    memory, key = problem.memory, (piece.first, s, s)
    errors = problem.errors_over(piece, s).largest_m
    if memory is not None:
        failed_m, reason = memory.failed.get(key, (inf, NO_INCLUSION))
        if errors >= failed_m:
            return reason
        if errors <= memory.proven.get(key, (-inf, None))[0]:
            return None
    found = prove_box(problem, piece, (s, s))
    if not isinstance(found, Reason):
        bounds = examine(_proven(problem, piece, found))
        if not isinstance(bounds, Reason):
            if memory is not None:
                memory.proven[key] = errors, None
            return None
        found = bounds
    if memory is not None:
        memory.failed[key] = errors, found
    return found


def join_chains(problem: ProofProblem, parts: Sequence[tuple[Piece, Chain]]) -> Chain:
    """Join chains over neighbouring pieces, proven for the errors of the problem or larger ones.

    What a box is proven for includes all smaller errors, so that only the joints between pieces have to be proven.
    """
    if (fault := _discontinuity(problem.pieces)) is not None:
        return Chain((), (), (), fault)
    joints = [*parts[0][1].joints]
    for (_, before), (piece, chain) in pairwise(parts):
        joint = prove_joint(problem, piece, piece.first)
        if isinstance(joint, Reason):
            return Chain((), (), (), ProofFailure(piece.first, joint))
        if not (holds(before.inclusions[-1], joint) and holds(chain.inclusions[0], joint)):
            return Chain((), (), (), ProofFailure(piece.first, JUMP))
        joints[-1:] = [joint, *chain.joints[1:]]
    inclusions = tuple(one for _, chain in parts for one in chain.inclusions)
    bounds = tuple(one for _, chain in parts for one in chain.bounds)
    return Chain(inclusions, bounds, tuple(joints), None)


def _chain(start: Inclusion, links: list[_Link], failure: ProofFailure | None) -> Chain:
    return Chain(
        inclusions=tuple(link.inclusion for link in links),
        bounds=tuple(link.bounds for link in links),
        joints=(start, *(link.joint for link in links)),
        failure=failure,
    )


def _prove_link(
    problem: ProofProblem, piece: Piece, interval: tuple[float, float], before: Inclusion, examine: Examiner
) -> _Link | Reason:
    """Prove a box, that it holds the pose `before` at its beginning, and that it holds a pose at its end."""
    found = prove_box(problem, piece, interval, _INFLATION * upper_vector(before.image))
    if isinstance(found, Reason):
        return found
    _, inclusion = found
    if not holds(inclusion, before):
        return JUMP
    # With errors, limits refuse more boxes than joints do.
    box = _proven(problem, piece, found)
    bounds = examine(box) if inclusion.following.any else None
    if isinstance(bounds, Reason):
        return bounds
    # What holds over the interval holds at its end, too.
    joint = prove_joint(problem, piece, interval[1], inclusion.box.radius)
    if isinstance(joint, Reason):
        return joint
    if not holds(inclusion, joint):
        return JUMP
    bounds = examine(box) if bounds is None else bounds
    return bounds if isinstance(bounds, Reason) else _Link(inclusion, bounds, joint)


def _proven(problem: ProofProblem, piece: Piece, found: tuple[Piecewise, Inclusion]) -> ProvenBox:
    return ProvenBox(problem.machine, problem.balls, piece, *found, ellipsoid=problem.uncertainty.ellipsoid)


def prove_joint(problem: ProofProblem, piece: Piece, s: float, likely: FloatArray | None = None) -> Inclusion | Reason:
    """Prove a box at a single s, whose radii are likely as large as those (6,) given."""
    found = prove_box(problem, piece, (s, s), likely)
    return found if isinstance(found, Reason) else found[1]


def holds(inclusion: Inclusion, joint: Inclusion) -> bool:
    """Return whether the image of a joint lies within a box at the same s, for every value of the uncertain parameters.

    The image is x' + C' e + P' a + [-k', k'] with the bound k' of the joint's inclusion; it holds the joint's one
    solution.

    Both have the same a, but each its own e; these differ by at most D |x - x'|, since what the parameters change
    depends on the pose.
    """
    offset = _offset(inclusion.box, joint.box.first)
    C = ball_matrix(inclusion.inverse[0]) + ball_matrix(inclusion.inverse[1]) * offset
    apart = _apart(inclusion.box, joint.box)
    reach = added(added(apart, joint.image), inclusion.following.change(offset, joint.following))
    if any(e > 0 for e in joint.residual_change):
        reach = added(reach, times(magnitudes(C - ball_matrix(joint.inverse[0])), joint.residual_change))
        reach = added(reach, times(inclusion.jacobian_change, apart))
    return all(far < arb(r) * SLACK for far, r in zip(reach, inclusion.box.radius.tolist(), strict=True))


def _apart(box: Box, joint: Box) -> list[arb]:
    """Bound |x(s) - x'| for the cubics of a box and of a joint."""
    offset = _offset(box, joint.first)
    at = [arb_poly([arb(value) for value in column])(offset) for column in box.pose.T.tolist()]
    return [(x - value).abs_upper() for x, value in zip(at, joint.pose[0].tolist(), strict=True)]


def _offset(box: Box, s: float) -> arb:
    """Compute s relative to the middle of a box, exactly."""
    return arb(exact(s) - exact(middle(box.first, box.last)[0]))


def _discontinuity(pieces: Sequence[Piece]) -> ProofFailure | None:
    """Find where pieces are not one continuous function on exactly [0, 1], in rational arithmetic."""
    if not pieces or (pieces[0].first, pieces[-1].last) != (0.0, 1.0):
        return ProofFailure(0.0, SPLINES_INCOMPLETE)
    for before, after in pairwise(pieces):
        if [q[:1] for q in before.taylor(after.first)] != [q[:1] for q in after.taylor(after.first)]:
            return ProofFailure(after.first, ACTUATORS_JUMP)
    return None
