"""A chain of boxes: it covers the path, each box holds one regular pose, and neighbours share a branch."""

from collections.abc import Iterator

import numpy as np

from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.inclusion import holds
from pipeline.certify.recheck.claims.claim import Claim

COVERED = "boxes cover s = 0 to 1"
ONE_POSE = "each box holds one regular pose"
SAME_BRANCH = "neighbouring boxes share a branch"
CLAIMS: tuple[str, ...] = (COVERED, ONE_POSE, SAME_BRANCH)


def chain_claims(of: str, chain: EvaluatedChain) -> Iterator[Claim]:
    """Verify that a chain of n boxes and n + 1 joints closes; `of` is what it is a chain of."""
    boxes, found, joints, met = chain.boxes, chain.inclusions, chain.joints, chain.joint_inclusions
    n = len(boxes.first)
    whole = boxes.first[0] == 0.0 and boxes.last[-1] == 1.0 and bool((boxes.first[1:] == boxes.last[:-1]).all())
    within = bool((boxes.first < boxes.last).all())
    yield Claim(f"{of}: {COVERED}", whole and within, f"{n} boxes from {boxes.first[0]:g} to {boxes.last[-1]:g}")
    across = n - int(boxes.on_one_piece.sum())
    beyond = f"; {across} reach across a knot of the splines" if across else ""
    yield Claim(f"{of}: {ONE_POSE}", bool(found.proven.all()), f"{int(found.proven.sum())} of {n}{beyond}")
    ends = np.append(boxes.first, boxes.last[-1])
    single = bool((joints.first == joints.last).all()) and np.array_equal(joints.first, ends)
    linked = holds(boxes, found, joints, met, at_end=False) & holds(boxes, found, joints, met, at_end=True)
    linked &= met.proven[1:] & met.proven[:-1]
    yield Claim(f"{of}: {SAME_BRANCH}", single and bool(linked.all()), f"{int(linked.sum())} of {n}")
