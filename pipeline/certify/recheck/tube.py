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
            Whether the limits of kappa, distances and joints are kept in it, too; otherwise the links close and no
            singularity is met, and that is all.
    """

    errors_m: FloatArray
    within_limits: bool

    @property
    def lost(self) -> str:
        """What is no longer proven outside of it, in words."""
        return (
            "limits of kappa, distances and joints may be broken"
            if self.within_limits
            else "nothing is proven of the machine"
        )

    @property
    def meaning(self) -> str:
        """What is proven in it, in words."""
        kept = "limits of kappa, distances and joints are kept" if self.within_limits else "but limits may be broken"
        return f"no singularity is met, {'and ' if self.within_limits else ''}{kept}"


def proven_tubes(chains: Sequence[ProvenChain]) -> tuple[ProvenTube, ...]:
    """Take the tubes of all actuators alike: one that keeps the limits, then a wider one that may break them.

    Of several chains of a kind the widest tube is taken: each is proven. There may be one of them, or none.
    """
    found = [
        ProvenTube(np.array(chain.uncertainty.actuator_m), chain.within_limits)
        for chain in sorted(filter(_alike, chains), key=lambda chain: chain.uncertainty.actuator_m[0])
    ]
    kept, broken = ([tube for tube in found if tube.within_limits is kind][-1:] for kind in (True, False))
    return (*kept, *(tube for tube in broken if not kept or tube.errors_m[0] > kept[0].errors_m[0]))


def _alike(chain: ProvenChain) -> bool:
    """Check whether a chain is of all actuators off alike, the same for all s; beside wrong calibrations, too."""
    errors = set(chain.uncertainty.actuator_m)
    return len(errors) == 1 and errors != {0.0} and chain.profile_m is None
