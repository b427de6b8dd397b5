"""How far all actuators may be off the path at a time, as the chains of a certificate have it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.result import ProvenChain


@dataclass(frozen=True, eq=False)
class ProvenTube:
    """The tube about the path in actuator space in which a machine as configured stays on its branch.

    Attributes
    ----------
    errors_m : (5,)
        How far c1, c2, c3, l2b, l3b may be off any point of the path, at a time and at any time.
    within_limits : bool
        Whether the limits of kappa and distances are kept in it, too; otherwise the links close and no singularity is
        met, and that is all.
    """

    errors_m: FloatArray
    within_limits: bool

    @property
    def meaning(self) -> str:
        """What is proven in it, in words."""
        kept = "limits of kappa and distances are kept" if self.within_limits else "limits may be broken"
        return f"no singularity is met, {kept}"


def proven_tube(chains: Sequence[ProvenChain]) -> ProvenTube | None:
    """Take the tube of all actuators alike: one that keeps the limits, if there is one; None without any.

    Of several of a kind it is the widest: each is proven.
    """
    found = [
        ProvenTube(np.array(chain.uncertainty.actuator_m), bool(getattr(chain, "within_limits", False)))
        for chain in chains
        if _alike(chain)
    ]
    return max(found, key=lambda tube: (tube.within_limits, float(tube.errors_m[0])), default=None)


def _alike(chain: ProvenChain) -> bool:
    """Check whether a chain is of all actuators off alike, and nothing else, the same for all s."""
    errors = set(chain.uncertainty.actuator_m)
    return len(errors) == 1 and errors != {0.0} and getattr(chain, "profile_m", None) is None
