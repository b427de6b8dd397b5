"""A chain of boxes: it covers the path, each box holds one regular pose, and neighbours share a branch.

Neighbours share a branch if the image of a third box, at the single s they meet at, lies within both: the image holds
the one pose of that box, which is then the one pose of either.
"""

from collections.abc import Iterator
from dataclasses import astuple, dataclass

import numpy as np

from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.inclusion import holds
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.result import ProvenChain

COVERED = "boxes cover s = 0 to 1"
ONE_POSE = "each box holds one regular pose"
SAME_BRANCH = "neighbouring boxes share a branch"
CLAIMS: tuple[str, ...] = (COVERED, ONE_POSE, SAME_BRANCH)


@dataclass(frozen=True)
class BoxCounts:
    """How many boxes are on one piece of the splines, proven, and linked to the joints at both of their ends."""

    boxes: int = 0
    on_one_piece: int = 0
    proven: int = 0
    linked: int = 0

    def __add__(self, other: "BoxCounts") -> "BoxCounts":
        return BoxCounts(*(mine + more for mine, more in zip(astuple(self), astuple(other), strict=True)))

    @property
    def all_hold(self) -> bool:
        """Whether every box is proven, and linked to its neighbours."""
        return self.proven == self.linked == self.boxes


def count_boxes(segment: EvaluatedChain) -> BoxCounts:
    """Count what is proven of a segment of boxes."""
    boxes, found, joints, met = segment.boxes, segment.inclusions, segment.joints, segment.joint_inclusions
    linked = holds(boxes, found, joints, met, at_end=False) & holds(boxes, found, joints, met, at_end=True)
    linked &= met.proven[1:] & met.proven[:-1]
    return BoxCounts(len(linked), int(boxes.on_one_piece.sum()), int(found.proven.sum()), int(linked.sum()))


def chain_claims(of: str, chain: ProvenChain, counted: BoxCounts) -> Iterator[Claim]:
    """Verify that a chain of n boxes and n + 1 joints closes; `of` is what it is a chain of.

    Boxes that were not counted are not verified.
    """
    n, whole = len(chain.boxes), _covers(chain)
    of_n = f"of {n}" if counted.boxes == n else f"of the first {counted.boxes} of {n}"
    ends = f"{n} boxes from {chain.boxes[0].first:g} to {chain.boxes[-1].last:g}"
    yield Claim(f"{of}: {COVERED}", whole, ends)
    across = counted.boxes - counted.on_one_piece
    beyond = f"; {across} reach across a knot of the splines" if across else ""
    yield Claim(f"{of}: {ONE_POSE}", counted.proven == n, f"{counted.proven} {of_n}{beyond}")
    met = _meet(chain)
    yield Claim(f"{of}: {SAME_BRANCH}", met and counted.linked == n, f"{counted.linked} {of_n}")


def closes(chain: ProvenChain) -> bool:
    """Return whether boxes reach from 0 to 1 and meet at the joints, whatever they hold."""
    return _covers(chain) and _meet(chain)


def _covers(chain: ProvenChain) -> bool:
    """Return whether boxes reach from exactly 0 to exactly 1, each wider than nothing, without gaps or overlaps."""
    first, last = (np.array([getattr(box, name) for box in chain.boxes]) for name in ("first", "last"))
    joined = first[0] == 0.0 and last[-1] == 1.0 and bool((first[1:] == last[:-1]).all())
    return joined and bool((first < last).all())


def _meet(chain: ProvenChain) -> bool:
    """Return whether joints are at a single s each, where the boxes begin and end."""
    ends = [chain.boxes[0].first, *(box.last for box in chain.boxes)]
    return [(joint.first, joint.last) for joint in chain.joints] == [(s, s) for s in ends]
