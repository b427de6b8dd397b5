"""All pairs that are kept apart, in one order."""

import numpy as np

from pipeline.config import Config
from pipeline.limits.bodies.pairs import kept_apart, pair_distances, pair_names
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples


def test_names_and_distances_are_in_one_order(bodies_config: Config, bodies_machine: Machine, draw_poses) -> None:
    """Pairs of the machine come first, then those with what is fixed in space; far ones are cut at the reach."""
    drawn = draw_poses(bodies_machine, 3, 5)
    samples = PoseSamples(bodies_machine, drawn.pose, drawn.q_m)
    kept = kept_apart(bodies_config, bodies_machine)
    names, distances = pair_names(kept), pair_distances(kept, samples)
    assert len(kept) == 2
    assert distances.shape == (len(samples), len(names))
    assert len(set(names)) == len(names)
    for bodies in kept:
        columns = [names.index(name) for name in bodies.names]
        np.testing.assert_array_equal(distances[:, columns], body_distances(bodies, samples))
    np.testing.assert_allclose(pair_distances(kept, samples, 0.1), np.minimum(distances, 0.1), atol=1e-9)


def test_nothing_is_kept_apart_without_bodies(quick_config: Config, machine: Machine) -> None:
    """Distances of axes are another matter."""
    assert kept_apart(quick_config, machine) == ()
