"""Bounds of kappa and signs of det H, for boxes whose values are known."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.certify import Certificate
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes, include
from pipeline.certify.recheck.claims.kappa import kappa_bounds
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine import Machine
from tests.certify.paths import RLL, START, TOWARDS_SINGULARITY, determinant, pose_path


@pytest.mark.parametrize("part", [0.6, 1.3])
def test_signs_of_det_h_are_those_on_either_side_of_a_singularity(
    machine: Machine, prove: Callable[..., Certificate], singular_at: float, part: float
) -> None:
    """One line of poses, before and beyond the singularity it goes through."""
    along = part * singular_at + np.linspace(0.0, 0.01, 6)
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL, 6)
    certificate = prove(machine, path, (RLL, RLL), kappa_excess=1.0)
    boxes = build_boxes(machine, path, certificate.chain.boxes)
    _, signs = kappa_bounds(machine, boxes, of_pose(machine, include(machine, boxes, CERTAIN).image))
    assert certificate.bounds is not None
    assert set(signs) == {np.sign(determinant(machine, float(along[0])))} == {certificate.bounds.det_sign}


def test_a_box_across_a_singularity_has_no_sign(
    machine: Machine, prove: Callable[..., Certificate], singular_at: float
) -> None:
    """Nor a bound of kappa: where poses may be a tenth off, H may be singular."""
    along = 0.9 * singular_at + np.linspace(0.0, 0.01, 6)
    path = pose_path(machine, START + along[:, None] * TOWARDS_SINGULARITY, RLL, 6)
    boxes = build_boxes(machine, path, prove(machine, path, (RLL, RLL), kappa_excess=1.0).chain.boxes)
    kappa, signs = kappa_bounds(machine, boxes, of_pose(machine, np.full((6, len(boxes.first)), 0.1)))
    assert not signs.any()
    assert np.isinf(kappa).all()
