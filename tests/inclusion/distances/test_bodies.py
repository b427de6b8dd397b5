"""Bounds of distances between bodies over a box: below every sample, and near the least."""

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.distances.bodies import body_distance_bounds
from pipeline.inclusion.krawczyk import Inclusion, along
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.samples import PoseSamples
from tests.certify.audit import samples_in
from tests.certify.paths import START, pose_path


@pytest.mark.parametrize("end", [[1.05, 0.33, 0.88, 0.05, -0.02], [0.9, 0.2, 0.8, -0.3, 0.25]])
def test_bounds_are_below_every_sample_and_sharp(bodies_machine: Machine, end: list[float]) -> None:
    """Of capsules, boxes, beams and links that are cut short or change their length."""
    machine, path = bodies_machine, pose_path(bodies_machine, np.linspace(START, end, 41), 0)
    assert machine.bodies is not None
    worst = []
    for piece in pieces(path.spline)[:2]:
        box = guess_box(path, piece.first, piece.last)
        assert box is not None
        with working_precision(64):
            balls = geometry(machine)
            series = along(balls, piece, box)
            none = [[arb(0)] * 6] * 6
            inclusion = Inclusion(box, np.zeros((2, 6, 6)), [arb(1e-9)] * 6, [arb(0)] * 6, none)
            bounds = body_distance_bounds(ProvenBox(machine, balls, piece, series, inclusion), machine.bodies)
        s = samples_in(box)
        sampled = body_distances(machine.bodies, PoseSamples(machine, path.pose(s), path.q(s))).min(axis=0)
        assert (bounds <= sampled).all()
        worst.append((sampled - bounds).max())
    assert max(worst) < 6e-3
