"""The bound of kappa over each box of a stored chain, by the arithmetic that verifies it."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.chain import SEGMENT
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes, include
from pipeline.certify.recheck.claims.kappa import kappa_bounds
from pipeline.certify.result import ProvenChain
from pipeline.machine.geometry import Machine
from pipeline.parallel import blocks
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class KappaProfile:
    """Upper bounds of kappa (n,) over boxes between neighbouring `edges` (n + 1,) of s; infinite if not proven."""

    edges: FloatArray
    kappa: FloatArray


def kappa_profile(machine: Machine, path: Path, chain: ProvenChain) -> KappaProfile:
    """Bound kappa over every box of a chain."""
    kappa = []
    # NaN compares as false: what cannot be computed is not proven.
    with np.errstate(all="ignore"):
        for part in blocks(len(chain.boxes), SEGMENT):
            boxes = build_boxes(machine, path, chain.boxes[part])
            found = include(machine, boxes, chain.uncertainty)
            kappa.append(np.where(found.proven, kappa_bounds(machine, boxes, of_pose(machine, found.image))[0], np.inf))
    edges = np.array([chain.boxes[0].first, *(box.last for box in chain.boxes)])
    return KappaProfile(edges, np.concatenate(kappa))
