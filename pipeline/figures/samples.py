"""Where the steps of the route are among the samples of a path."""

import numpy as np

from pipeline.arrays import IntArray
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route


def corner_samples(coarse: PathSamples, route: Route) -> IntArray:
    """Find the sample of the coarse path nearest in actuator space to each step of the route. Shape (n,).

    Where the route returns to the same place, steps are found in their order.
    """
    spacing = float(np.linalg.norm(np.diff(coarse.q_m, axis=0), axis=1).max())
    found = [0]
    for q in route.q_m:
        distance = np.linalg.norm(coarse.q_m[found[-1] :] - q, axis=1)
        passes = np.flatnonzero(distance <= distance.min() + spacing)
        first = passes[: 1 + int(np.argmax(np.append(np.diff(passes), 2) > 1))]
        found.append(found[-1] + int(first[np.argmin(distance[first])]))
    return np.array(found[1:])
