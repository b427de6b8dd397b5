"""All pairs of bodies that a configuration keeps apart, whether x plays a role in their distances or not."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies


def kept_apart(config: Config, machine: Machine) -> tuple[Bodies, ...]:
    """Return the bodies of a machine, and what is fixed in space around them, as far as there are any."""
    return tuple(bodies for bodies in (machine.bodies, obstacles_of(config)) if bodies is not None)


def pair_names(kept: tuple[Bodies, ...]) -> tuple[str, ...]:
    """Name all pairs, one group of bodies after the other."""
    return tuple(name for bodies in kept for name in bodies.names)


def pair_distances(kept: tuple[Bodies, ...], samples: PoseSamples, reach_m: float = np.inf) -> FloatArray:
    """Compute the distances of all pairs at n poses, in the order of `pair_names`, shape (n, pairs).

    What is beyond `reach_m` has that value.
    """
    return np.concatenate([body_distances(bodies, samples, reach_m) for bodies in kept], axis=1)
