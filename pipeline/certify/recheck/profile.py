"""The bound of kappa over each box of a stored chain, by the arithmetic that verifies it."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes, include
from pipeline.certify.recheck.claims.kappa import kappa_bounds
from pipeline.certify.result import ProvenChain
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class KappaProfile:
    """Upper bounds of kappa (n,) over boxes between neighbouring `edges` (n + 1,) of s; infinite if not proven."""

    edges: FloatArray
    kappa: FloatArray


def kappa_profile(machine: Machine, path: Path, chain: ProvenChain) -> KappaProfile:
    """Bound kappa over every box of a chain."""
    boxes = build_boxes(machine, path, chain.boxes)
    # NaN compares as false: what cannot be computed is not proven.
    with np.errstate(all="ignore"):
        found = include(machine, boxes, chain.uncertainty)
        kappa, _ = kappa_bounds(machine, boxes, found.image)
    return KappaProfile(np.append(boxes.first, boxes.last[-1]), np.where(found.proven, kappa, np.inf))
