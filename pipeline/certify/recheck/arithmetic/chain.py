"""A stored chain, evaluated again."""

from dataclasses import dataclass

from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions, build_boxes, include
from pipeline.certify.result import ProvenChain
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class EvaluatedChain:
    """The n boxes of a chain and its n + 1 joints, and the inclusions of both."""

    boxes: Boxes
    inclusions: Inclusions
    joints: Boxes
    joint_inclusions: Inclusions


def evaluate_chain(machine: Machine, path: Path, chain: ProvenChain) -> EvaluatedChain:
    """Evaluate the inclusions of all boxes and joints of a chain.

    Raises
    ------
    numpy.linalg.LinAlgError, ValueError, OverflowError
        If numbers are too large to compute with, or a matrix is singular.
    """
    boxes, joints = (build_boxes(machine, path, part) for part in (chain.boxes, chain.joints))
    inclusions, joint_inclusions = (include(machine, part, chain.uncertainty) for part in (boxes, joints))
    return EvaluatedChain(boxes, inclusions, joints, joint_inclusions)
