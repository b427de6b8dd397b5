"""Bounds of kappa and distances for all errors of the actuators: never passed by a sample, and sharp to first order."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic import inclusion as again
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.erring import erring
from pipeline.certify.recheck.claims.distances.axis_distances import distance_bounds as distances_again
from pipeline.certify.recheck.claims.kappa import kappa_bounds as kappa_again
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.condition import kappa_bound
from pipeline.inclusion.distances.axes import AxisPairs, distance_bounds
from pipeline.inclusion.krawczyk import along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import of_actuators
from pipeline.machine import Machine
from pipeline.machine.clearance import link_distances, link_pairs, link_rail_distances, rail_pairs
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from tests.certify.paths import line_path
from tests.rails import off_x

_CORNERS = np.array(list(itertools.product([-1.0, 1.0], repeat=5)))


@dataclass(frozen=True, eq=False)
class Found:
    """Bounds and worst samples over one box: kappa, and distances of all pairs."""

    kappa: float
    sampled_kappa: float
    distances_m: np.ndarray
    sampled_m: np.ndarray
    kappa_again: float
    distances_again_m: np.ndarray


def _prove(machine: Machine, path: Path, eps: float) -> ProvenBox:
    """Prove a box over a fifth of the first piece."""
    piece, kind = pieces(path.spline)[0], of_actuators(np.ones(5))
    box = guess_box(path, piece.first, piece.first + 0.2 * (piece.last - piece.first))
    assert box is not None
    balls = geometry(machine)
    series = along(balls, piece, box)
    inclusion = include(balls, series, box, kind(eps))
    assert inclusion is not None
    return ProvenBox(machine, balls, piece, series, inclusion)


def _bounded(machine: Machine, path: Path, eps: float, *, from_rail: bool = False) -> Found:
    pairs = AxisPairs.of(rail_pairs(machine) if from_rail else link_pairs(machine), from_rail, machine)
    with working_precision(64):
        box = _prove(machine, path, eps)
        kappa = kappa_bound(box.balls, box.series, box.displacement, box.erring)
        least = distance_bounds(pairs, box.series, box.displacement, box.erring)
    assert kappa.det_sign == 1
    boxes = again.build_boxes(machine, path, (box.inclusion.box,))
    found = again.include(machine, boxes, of_actuators(np.ones(5))(eps))
    assert found.proven.all()
    errors = erring(machine, boxes, found)
    other, signs = kappa_again(machine, boxes, of_pose(machine, found.image), errors)
    assert signs.tolist() == [1.0]
    samples = _samples(machine, path, box, eps)
    return Found(
        kappa.kappa,
        float(samples.kappa.max()),
        least,
        (link_rail_distances if from_rail else link_distances)(machine, samples.pose, samples.carts_m).min(axis=0),
        float(other[0]),
        distances_again(machine, pairs, boxes, (of_pose(machine, found.image), errors))[:, 0],
    )


def _samples(machine: Machine, path: Path, box: ProvenBox, eps: float) -> PoseSamples:
    """Evaluate all corners and some errors between them, at several s."""
    s = np.linspace(box.inclusion.box.first, box.inclusion.box.last, 7)
    errors = np.concatenate([_CORNERS, np.random.default_rng(1).uniform(-1.0, 1.0, (32, 5))])
    q = (path.q(s)[:, None] + eps * errors).reshape(-1, 5)
    pose, miss = newton(machine, q, np.repeat(path.pose(s), len(errors), axis=0))
    assert (miss < 1e-9).all()
    return PoseSamples(machine, pose, q)


@pytest.mark.parametrize("eps", [0.0, 1e-4, 1e-3, 2e-3])
def test_no_sample_passes_a_bound(machine: Machine, line: Path, eps: float) -> None:
    """In either arithmetic."""
    found = _bounded(machine, line, eps)
    assert found.sampled_kappa <= min(found.kappa, found.kappa_again)
    assert (found.sampled_m >= np.maximum(found.distances_m, found.distances_again_m)).all()


@pytest.mark.parametrize("eps", [0.0, 1e-3])
@pytest.mark.parametrize("from_rail", [False, True])
def test_no_sample_passes_a_bound_on_rails_off_x(machine: Machine, eps: float, from_rail: bool) -> None:
    """In either arithmetic, of links among themselves and of links and rails; and bounds are near."""
    skewed = off_x(machine)
    found = _bounded(skewed, line_path(skewed), eps, from_rail=from_rail)
    assert found.sampled_kappa <= min(found.kappa, found.kappa_again)
    least, again_m = found.distances_m, found.distances_again_m
    assert (found.sampled_m >= np.maximum(least, again_m)).all()
    assert (np.minimum(least, again_m) >= found.sampled_m - 2e-3 - 5.0 * eps).all()


def test_bounds_are_sharp_to_first_order(machine: Machine, line: Path) -> None:
    """Half the errors add half; norms of H and of its inverse are bounded apart, gaps of axes one by one."""
    none, half, whole = (_bounded(machine, line, eps) for eps in (0.0, 1e-4, 2e-4))
    by_bound, by_sample = whole.kappa - none.kappa, whole.sampled_kappa - none.sampled_kappa
    assert by_sample < by_bound < 4.0 * by_sample
    assert half.kappa - none.kappa == pytest.approx(by_bound / 2.0, rel=0.1)
    near = none.distances_m < 0.2
    closer = none.distances_m - whole.distances_m
    assert near.any()
    assert (closer[near] < 1.3 * (none.sampled_m - whole.sampled_m)[near]).all()


@pytest.mark.parametrize("eps", [1e-4, 1e-3])
def test_both_arithmetics_agree(machine: Machine, line: Path, eps: float) -> None:
    """To what the proof adds for that: the images of the check are used where the proof uses radii."""
    found = _bounded(machine, line, eps)
    assert found.kappa_again <= found.kappa
    assert found.kappa_again == pytest.approx(found.kappa, rel=0.02)
    assert (found.distances_again_m >= found.distances_m - 5e-5).all()
