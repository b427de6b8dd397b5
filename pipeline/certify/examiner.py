"""Bounds of all limits over a proven box, and how sharp that of kappa has to be."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.chain import BoxBounds, Examiner
from pipeline.certify.reasons import Reason
from pipeline.config import CertifyConfig
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.limits.interface.limit import ErrorProvenLimit, ProvenLimit, RoughlyProvenLimit
from pipeline.limits.kappa import KappaCap

_SHARP_ENOUGH = 1e-5
"""Boxes are not halved below this width only to bound kappa more sharply."""

_SUSPECTS = 3
"""Pairs that are asked first."""


@dataclass(frozen=True, eq=False)
class LimitExaminer:
    """Bounds all limits over a proven box; called by the chain with every box.

    Boxes are halved until the bound of kappa is near its largest value at samples: a limit may be kept by far, and the
    certificate is to say how far.

    Attributes
    ----------
    limits : list of ProvenLimit
        The limits.
    kappa_goal : float
        Boxes are halved until kappa is proven below this,
    sharp_width : float
        unless they are narrower than this.
    """

    limits: list[ProvenLimit]
    kappa_goal: float
    sharp_width: float

    def __call__(self, box: ProvenBox) -> BoxBounds | Reason:
        """Bound every limit over a box; give the reason if the box has to be halved."""
        interval = box.inclusion.box
        wide, found = interval.last - interval.first >= self.sharp_width, []
        for limit in self.limits:
            bounds = limit.bound(box)
            if isinstance(limit, KappaCap) and wide and bounds[0, 1] > self.kappa_goal:
                return Reason(f"kappa is not proven below {self.kappa_goal:.4g}", limit.wording.proof_advice)
            if text := limit.unproven(bounds):
                return Reason(text, limit.wording.proof_advice)
            found.append(bounds)
        return tuple(found)


def build_error_examiner(limits: Sequence[ErrorProvenLimit]) -> Examiner:
    """Ask that limits be kept for every error of the actuators; how sharp their bounds are does not count.

    Few limits refuse boxes, of many pairs few, and mostly the same ones, of neighbouring boxes and for other errors:
    those that did so lately are asked first.
    """
    suspects: dict[tuple[int, int], ErrorProvenLimit] = {}
    in_order = list(enumerate(limits))

    def examine(box: ProvenBox) -> BoxBounds | Reason:
        for key, limit in [*suspects.items()][::-1]:
            bounds = limit.bound(box)
            if text := limit.unproven(bounds):
                suspects[key] = suspects.pop(key)
                return Reason(text, limit.wording.proof_advice, _least_kept(limit, bounds))
        for k, (number, limit) in enumerate(in_order):
            bounds = limit.rough_bound(box) if isinstance(limit, RoughlyProvenLimit) else limit.bound(box)
            if text := limit.unproven(bounds):
                in_order.insert(0, in_order.pop(k))
                if isinstance(limit, RoughlyProvenLimit):
                    worst = int(bounds[:, 0].argmin())
                    suspects[number, worst] = limit.only(np.array([worst]))
                    while len(suspects) > _SUSPECTS:
                        del suspects[next(iter(suspects))]
                return Reason(text, limit.wording.proof_advice, _least_kept(limit, bounds))
        return ()

    return examine


def _least_kept(limit: ErrorProvenLimit, bounds: FloatArray) -> str:
    """Name the quantity that is farthest beyond its limit."""
    allowed = np.array([quantity.allowed for quantity in limit.quantities])
    with np.errstate(invalid="ignore"):
        beyond = np.fmax(allowed[:, 0] - bounds[:, 0], bounds[:, 1] - allowed[:, 1])
    return limit.quantities[int(beyond.argmax())].subject


def build_examiner(options: CertifyConfig, limits: list[ProvenLimit], kappa_sampled: float) -> LimitExaminer:
    """Ask for a bound of kappa within `certify.kappa_excess` of its largest value at samples, and below its cap."""
    caps = [limit.cap for limit in limits if isinstance(limit, KappaCap)]
    return LimitExaminer(
        limits=limits,
        kappa_goal=min(*caps, (1.0 + options.kappa_excess) * kappa_sampled),
        # A box that is too narrow to be halved must not be refused only because its bound is not sharp.
        sharp_width=max(_SHARP_ENOUGH, 2.0 * options.least_width),
    )
