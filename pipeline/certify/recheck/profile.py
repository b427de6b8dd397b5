"""What a stored chain proves of kappa box by box, by the same arithmetic that verifies it."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.bounds import kappa_bounds
from pipeline.certify.recheck.inclusion import build_boxes, include
from pipeline.certify.result import ProvenChain
from pipeline.machine.geometry import Machine
from pipeline.refine.result import Path


@dataclass(frozen=True, eq=False)
class KappaProfile:
    """Upper bounds of kappa (n,) over boxes that reach from `edges` (n + 1,) of s to the next; infinite: unproven."""

    edges: FloatArray
    kappa: FloatArray


def kappa_profile(machine: Machine, path: Path, chain: ProvenChain) -> KappaProfile:
    """Bound kappa over every box of a chain."""
    boxes = build_boxes(machine, path, chain.boxes)
    # Numbers that are none compare as false: what cannot be computed is not proven.
    with np.errstate(all="ignore"):
        found = include(machine, boxes, chain.uncertainty)
        kappa, _ = kappa_bounds(machine, boxes, found.image)
    return KappaProfile(np.append(boxes.first, boxes.last[-1]), np.where(found.proven, kappa, np.inf))
