"""What the figures read off samples of a path: where the route's steps are."""

import numpy as np

from pipeline.machine.geometry import IntArray
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route


def corner_samples(coarse: PathSamples, route: Route) -> IntArray:
    """Find the sample of the coarse path nearest in actuator space to each step of the route. Shape (n,)."""
    distance = np.linalg.norm(coarse.q_m[None] - route.q_m[:, None], axis=2)
    nearest: IntArray = np.argmin(distance, axis=1)
    return nearest
