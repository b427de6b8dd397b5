"""A stored chain, evaluated again: a segment of boxes at a time, so that memory does not grow with the chain."""

from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions, build_boxes, include
from pipeline.certify.result import ProvenChain
from pipeline.machine.geometry import Machine
from pipeline.parallel import blocks
from pipeline.refine.result import Path

SEGMENT = 1_024
"""Boxes evaluated at a time: about a hundred MB of arrays."""


@dataclass(frozen=True, eq=False)
class EvaluatedChain:
    """The n boxes of a segment of a chain and its n + 1 joints, and the inclusions of both."""

    boxes: Boxes
    inclusions: Inclusions
    joints: Boxes
    joint_inclusions: Inclusions


def evaluate_chain(machine: Machine, path: Path, chain: ProvenChain) -> Iterator[EvaluatedChain]:
    """Evaluate the inclusions of all boxes and joints of a chain, segment by segment.

    Raises
    ------
    numpy.linalg.LinAlgError, ValueError, OverflowError
        If numbers are too large to compute with, or a matrix is singular.
    """
    for part in blocks(len(chain.boxes), SEGMENT):
        boxes = build_boxes(machine, path, chain.boxes[part])
        joints = build_boxes(machine, path, chain.joints[part.start : part.stop + 1])
        inclusions, joint_inclusions = (include(machine, each, chain.uncertainty) for each in (boxes, joints))
        yield EvaluatedChain(boxes, inclusions, joints, joint_inclusions)


def evaluate_ends(machine: Machine, path: Path, chain: ProvenChain) -> tuple[Boxes, Inclusions]:
    """Evaluate the first and the last joint of a chain; raises what `evaluate_chain` does."""
    joints = build_boxes(machine, path, (chain.joints[0], chain.joints[-1]))
    return joints, include(machine, joints, chain.uncertainty)
