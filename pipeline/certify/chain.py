"""The chain of boxes from s = 0 to s = 1: where a box cannot be proven it is halved, until the chain closes or breaks.

Two neighbouring boxes hold the same branch when a third inclusion, at the single s they share, lies within both: there
is exactly one solution in each of the three.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

from flint import arb, arb_poly

from pipeline.certify.guess import guess_box, point_box
from pipeline.errors import ForwardKinematicsError
from pipeline.inclusion.closure import Geometry
from pipeline.inclusion.krawczyk import (
    SLACK,
    Box,
    Inclusion,
    Piecewise,
    added,
    along,
    ball_matrix,
    include,
    magnitudes,
    times,
)
from pipeline.inclusion.pieces import Piece, exact, middle
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.progress import Progress, silent
from pipeline.refine.result import Path

F = TypeVar("F")
Examine = Callable[[Piece, Piecewise, Inclusion], tuple[F, str]]
"""Looks at a proven box: what it found, and in words what is not good enough yet; nothing where all is well."""

NO_POSE = "the links cannot close"
NO_INCLUSION = "no box could be proven to hold exactly one pose"
JUMP = "the path jumps from one branch to another"


@dataclass(frozen=True)
class Break:
    """Where a chain does not close, and why."""

    s: float
    why: str


@dataclass(frozen=True, eq=False)
class Chain(Generic[F]):
    """Proven boxes in order, what was found out about each, the proven poses at their ends, and where it broke.

    Attributes
    ----------
    inclusions, facts : n
        The boxes, and what `Examine` found in them.
    joints : n + 1
        Inclusions at single s: the ends of the boxes.
    broken : Break or None
        None when the chain reaches s = 1.
    """

    inclusions: tuple[Inclusion, ...]
    facts: tuple[F, ...]
    joints: tuple[Inclusion, ...]
    broken: Break | None


def examine_nothing(piece: Piece, series: Piecewise, inclusion: Inclusion) -> tuple[None, str]:
    """Be content with any box."""
    return None, ""


def close_chain(
    machine: Geometry,
    path: Path,
    pieces: list[Piece],
    least_width: float,
    examine: Examine[F],
    uncertainty: Uncertainty = CERTAIN,
    progress: Progress = silent,
) -> Chain[F]:
    """Prove boxes from s = 0 on until the chain has reached s = 1, or an interval narrower than `least_width` fails."""
    if (fault := _no_function(pieces)) is not None:
        return Chain((), (), (), fault)
    links: list[tuple[Inclusion, F, Inclusion]] = []
    start, why = prove_joint(machine, path, pieces[0], pieces[0].first, uncertainty)
    if start is None:
        return Chain((), (), (), Break(pieces[0].first, why))
    for piece in pieces:
        waiting = [(piece.first, piece.last)]
        while waiting:
            first, last = waiting.pop()
            before = links[-1][2] if links else start
            link, why = _prove_link(machine, path, piece, (first, last), before, examine, uncertainty)
            if link is not None:
                links.append(link)
                progress(f"{len(links)} boxes", last)
            elif last - first < 2.0 * least_width:
                return _chain(start, links, Break((first + last) / 2.0, why))
            else:
                centre, _ = middle(first, last)
                waiting += [(centre, last), (first, centre)]
    return _chain(start, links, None)


def _chain(start: Inclusion, links: list[tuple[Inclusion, F, Inclusion]], broken: Break | None) -> Chain[F]:
    return Chain(
        tuple(inclusion for inclusion, _, _ in links),
        tuple(facts for _, facts, _ in links),
        (start, *(joint for _, _, joint in links)),
        broken,
    )


def _prove_link(
    machine: Geometry,
    path: Path,
    piece: Piece,
    interval: tuple[float, float],
    before: Inclusion,
    examine: Examine[F],
    uncertainty: Uncertainty,
) -> tuple[tuple[Inclusion, F, Inclusion] | None, str]:
    """Prove a box, that it holds the pose `before` at its beginning, and a pose at its end; or say what is wrong."""
    box = guess_box(path, *interval)
    if box is None:
        return None, NO_POSE
    series = along(machine, piece, box)
    inclusion = include(machine, series, box, uncertainty)
    if inclusion is None:
        return None, NO_INCLUSION
    if not holds(inclusion, before):
        return None, JUMP
    joint, why = prove_joint(machine, path, piece, interval[1], uncertainty)
    if joint is None or not holds(inclusion, joint):
        return None, why or JUMP
    facts, why = examine(piece, series, inclusion)
    return (None, why) if why else ((inclusion, facts, joint), "")


def prove_joint(
    machine: Geometry, path: Path, piece: Piece, s: float, uncertainty: Uncertainty
) -> tuple[Inclusion | None, str]:
    """Prove a box at a single s."""
    try:
        box = point_box(s, path.pose(s))
    except ForwardKinematicsError:
        return None, NO_POSE
    inclusion = include(machine, along(machine, piece, box), box, uncertainty)
    return inclusion, "" if inclusion is not None else NO_INCLUSION


def holds(inclusion: Inclusion, joint: Inclusion) -> bool:
    """Tell whether all a joint may be lies within a box at the same s, for every value of the uncertain parameters.

    The two have e of their own, apart by at most D |x - x'|: what the parameters change depends on the pose.
    """
    C = ball_matrix(inclusion.inverse[0]) + ball_matrix(inclusion.inverse[1]) * _offset(inclusion.box, joint.box.first)
    apart = _apart(inclusion.box, joint.box)
    reach = added(apart, joint.image)
    if any(e > 0 for e in joint.residual_change):
        reach = added(reach, times(magnitudes(C - ball_matrix(joint.inverse[0])), joint.residual_change))
        reach = added(reach, times(magnitudes(C), times(inclusion.jacobian_change, apart)))
    return all(far < arb(r) * SLACK for far, r in zip(reach, inclusion.box.radius.tolist(), strict=True))


def _apart(box: Box, joint: Box) -> list[arb]:
    """|x(s) - x'| for the cubics of a box and of a joint."""
    offset = _offset(box, joint.first)
    at = [arb_poly([arb(value) for value in column])(offset) for column in box.pose.T.tolist()]
    return [(x - value).abs_upper() for x, value in zip(at, joint.pose[0].tolist(), strict=True)]


def _offset(box: Box, s: float) -> arb:
    """Give s counted from the middle of a box, exactly."""
    return arb(exact(s) - exact(middle(box.first, box.last)[0]))


def _no_function(pieces: list[Piece]) -> Break | None:
    """Find out where pieces are no continuous function on all of [0, 1], and nothing else, in rational arithmetic."""
    if not pieces or (pieces[0].first, pieces[-1].last) != (0.0, 1.0):
        return Break(0.0, "the splines do not reach from s = 0 to s = 1")
    for before, after in pairwise(pieces):
        if [q[:1] for q in before.taylor(after.first)] != [q[:1] for q in after.taylor(after.first)]:
            return Break(after.first, "the actuators jump")
    return None
