"""Bounds of distances over a box, by directions that need not be right."""

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.displacement import of_pose
from pipeline.inclusion.distances import axes
from pipeline.inclusion.distances.axes import AxisPairs, distance_bounds, separating_directions
from pipeline.inclusion.krawczyk import along
from pipeline.inclusion.pieces import pieces
from pipeline.machine import link_distances
from pipeline.machine.clearance import link_pairs, link_rail_distances, rail_pairs
from pipeline.refine import Path
from tests.certify.audit import samples_in


def bounds_and_samples(path: Path, from_rail: bool) -> tuple[np.ndarray, np.ndarray]:
    """Bound the distances of all pairs over the first piece of a path, and sample them."""
    machine, piece = path.machine, pieces(path.spline)[0]
    box = guess_box(path, piece.first, piece.last)
    assert box is not None
    pairs = AxisPairs.of(rail_pairs(machine) if from_rail else link_pairs(machine), from_rail, machine)
    with working_precision(64):
        balls = geometry(machine)
        bounds = distance_bounds(pairs, along(balls, piece, box), of_pose(balls, [arb(1e-9)] * 6))
    s = samples_in(box)
    sampled = (link_rail_distances if from_rail else link_distances)(machine, path.pose(s), path.q(s)[:, :3])
    return bounds, sampled.min(axis=0)


@pytest.mark.parametrize("from_rail", [False, True])
def test_bounds_are_below_every_sample_and_sharp(line: Path, from_rail: bool) -> None:
    """Of links among themselves, and of links and rails."""
    bounds, sampled = bounds_and_samples(line, from_rail)
    assert (bounds <= sampled).all()
    np.testing.assert_allclose(bounds, sampled, atol=1e-3)


def test_wrong_directions_give_weaker_bounds(line: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any direction will do: what it proves is true."""
    good, sampled = bounds_and_samples(line, from_rail=False)

    def turned(pairs: AxisPairs, points: np.ndarray) -> np.ndarray:
        right = separating_directions(pairs, points)
        return right + 0.3 * right[..., [1, 2, 0]]

    monkeypatch.setattr(axes, "separating_directions", turned)
    weak, _ = bounds_and_samples(line, from_rail=False)
    assert (weak <= sampled).all()
    assert (weak < good).any()
