"""A stored chain, evaluated again: a segment of boxes at a time, so that memory does not grow with the chain."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.calibrated.displacement import Displacement, of_machines, of_pose
from pipeline.certify.recheck.arithmetic.erring import Erring, erring
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, Inclusions, build_boxes, include
from pipeline.certify.result import ProvenChain
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.parallel import blocks
from pipeline.refine.result import Path

SEGMENT = 1_024
"""Boxes evaluated at a time: about a hundred MB of arrays."""


@dataclass(frozen=True, eq=False)
class EvaluatedChain:
    """The n boxes of a segment of a chain and its n + 1 joints, the inclusions of both, and machines they hold for."""

    boxes: Boxes
    inclusions: Inclusions
    joints: Boxes
    joint_inclusions: Inclusions
    ellipsoid: Ellipsoid | None = None

    def erring(self, machine: Machine) -> Erring | None:
        """The boxes for all errors of their actuators; None if there are none."""
        return erring(machine, self.boxes, self.inclusions)

    def displacement(self, machine: Machine) -> Displacement:
        """How far joints and lengths may be from those along the cubics, for all machines that the chain is for."""
        if self.ellipsoid is None:
            return of_pose(machine, self.inclusions.image)
        return of_machines(machine, self.boxes, self.inclusions, self.ellipsoid)


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
        errors = _errors(chain, part), _errors_at_joints(chain, slice(part.start, part.stop + 1))
        inclusions, joint_inclusions = (
            include(machine, each, chain.uncertainty, off) for each, off in zip((boxes, joints), errors, strict=True)
        )
        yield EvaluatedChain(boxes, inclusions, joints, joint_inclusions, chain.uncertainty.ellipsoid)


def _errors(chain: ProvenChain, part: slice) -> FloatArray | None:
    """Give the errors of the actuators over boxes, (5, n); None if they are the same for all."""
    if chain.profile_m is None:
        return None
    return np.tile(np.array(chain.profile_m)[part], (len(ACTUATORS), 1))


def _errors_at_joints(chain: ProvenChain, part: slice) -> FloatArray | None:
    """Give the errors of the actuators at joints: the smaller ones of both neighbours."""
    if chain.profile_m is None:
        return None
    profile = np.array(chain.profile_m)
    meeting = np.minimum(np.append(profile, np.inf), np.insert(profile, 0, np.inf))
    return np.tile(meeting[part], (len(ACTUATORS), 1))


def evaluate_ends(machine: Machine, path: Path, chain: ProvenChain) -> tuple[Boxes, Inclusions]:
    """Evaluate the first and the last joint of a chain; raises what `evaluate_chain` does."""
    joints = build_boxes(machine, path, (chain.joints[0], chain.joints[-1]))
    return joints, include(machine, joints, chain.uncertainty)
