"""Distances of the machine's bodies against another library, coal, where it is installed."""

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.limits.bodies.pairs import kept_apart
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from tests.certify.paths import line_path
from tests.machine.bodies.coal_oracle import CoalOracle

pytest.importorskip("coal", reason="coal is not installed: make consumers")
WORKPIECE = {"name": "workpiece", "box": {"centre_m": [1.0, 0.3, 0.45], "size_m": [0.3] * 3, "rounding_m": 0.01}}
WEDGE = {"name": "wedge", "hull": {"points_m": [[0.2, 0.1, 0.4], [0.6, 0.1, 0.4], [0.4, 0.4, 0.5], [0.4, 0.2, 0.9]]}}
ASKED = 10_000


@pytest.fixture(scope="module")
def config(bodies_config: Config, vary) -> Config:
    """Put a workpiece and a wedge into the frame of the machine with bodies, among its posts."""
    return vary(bodies_config, {"task.obstacles": [WORKPIECE, WEDGE]})


def test_distances_at_random_poses_are_those_of_coal(config: Config, bodies_machine: Machine, draw_poses) -> None:
    """10,000 of poses and pairs of all kinds to 1e-9; where hulls overlap there is no depth to compare."""
    drawn, rng = draw_poses(bodies_machine, 11, 600), np.random.default_rng(3)
    samples = PoseSamples(bodies_machine, drawn.pose, drawn.q_m)
    for bodies in kept_apart(config, bodies_machine):
        mine, oracle = body_distances(bodies, samples), CoalOracle(bodies, samples)
        radii = np.array([bodies.radii_m(pair) for pair in bodies.pairs])
        for k in rng.permutation(mine.size)[: ASKED // 2].tolist():
            row, pair = divmod(k, mine.shape[1])
            theirs = oracle.distance(pair, row)
            if mine[row, pair] > 1e-9 - radii[pair]:
                assert mine[row, pair] == pytest.approx(theirs, abs=1e-9), bodies.names[pair]
            else:
                assert theirs < 1e-8 - radii[pair]


def test_no_pose_is_passed_over_that_is_nearer(config: Config, bodies_machine: Machine) -> None:
    """Along a path most poses are not asked for; with a level at the least distance it is found."""
    path, s = line_path(bodies_machine), np.linspace(0.0, 1.0, 1_001)
    samples = PoseSamples(bodies_machine, path.pose(s), path.q(s))
    for bodies in kept_apart(config, bodies_machine):
        oracle, least = CoalOracle(bodies, samples), body_distances(bodies, samples).min(axis=0)
        apart = np.flatnonzero(least > 0.0)[::20]
        for k in apart.tolist():
            assert oracle.least(k, least[k] - 1e-3) >= least[k] - 1e-9
            assert oracle.least(k, least[k]) == pytest.approx(least[k], abs=1e-9)
        assert oracle.asked < 0.5 * len(apart) * len(samples)
