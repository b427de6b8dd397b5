"""Bounds of actuators and tilts over a proven box hold at every sample of it."""

from collections.abc import Iterator

import numpy as np
import pytest

from pipeline.certify.guess import guess_box
from pipeline.inclusion.bounds import actuator_ranges, tilt_magnitudes
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.krawczyk import along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.refine import Path
from tests.certify.audit import samples_in


@pytest.fixture
def box(line: Path) -> Iterator[ProvenBox]:
    """Prove a box over the first piece of a path."""
    with working_precision(64):
        balls, piece = geometry(line.machine), pieces(line.spline)[0]
        guess = guess_box(line, piece.first, piece.last)
        assert guess is not None
        series = along(balls, piece, guess)
        inclusion = include(balls, series, guess)
        assert inclusion is not None
        yield ProvenBox(line.machine, balls, piece, series, inclusion)


def test_actuators_stay_within_their_ranges(line: Path, box: ProvenBox) -> None:
    """And reach both ends of them, nearly."""
    q, ranges = line.q(samples_in(box.inclusion.box)), actuator_ranges(box)
    assert (ranges[:, 0] <= q.min(axis=0)).all()
    assert (q.max(axis=0) <= ranges[:, 1]).all()
    np.testing.assert_allclose(ranges, np.column_stack([q.min(axis=0), q.max(axis=0)]), atol=1e-6)


def test_tilts_are_at_most_their_bounds(line: Path, box: ProvenBox) -> None:
    """Whichever way the platform tilts."""
    tilt = np.abs(line.pose(samples_in(box.inclusion.box))[:, [3, 5]]).max(axis=0)
    largest = tilt_magnitudes(box)
    assert (tilt <= largest).all()
    np.testing.assert_allclose(largest, tilt, atol=1e-5)
