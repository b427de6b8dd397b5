"""Every rigorous step is needed: each one broken on purpose lets something wrong pass, and that is noticed here.

A witness is a statement that holds as long as the steps are rigorous. It is run as it is, and with a step broken.
"""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import arb, arb_series

from pipeline.certify import clearance, closure, inclusion, kappa, ranges
from pipeline.certify.chain import close_chain, examine_nothing, holds, prove_joint
from pipeline.certify.closure import geometry, pose_series, working_precision
from pipeline.certify.guess import guess_box
from pipeline.certify.inclusion import Box, along, include
from pipeline.certify.pieces import pieces
from pipeline.certify.recheck import enclosure
from pipeline.certify.uncertainty import CERTAIN, Uncertainty
from pipeline.machine import condition_number, link_distances, statics_matrix
from pipeline.refine import Path
from tests.certify.audit import ROUNDING, cubic, deviations, samples_in


def _box(path: Path) -> Box:
    found = guess_box(path, 0.0, pieces(path.spline)[0].last)
    assert found is not None
    return found


def _whole(path: Path) -> tuple[Box, object]:
    """Widen the path's first piece to a fast one: poses that hardly move hide what is missing."""
    box = _box(path)
    return box, along(geometry(path.machine), pieces(path.spline)[0], box)


def witness_residual(path: Path) -> None:
    """A box that stands still holds its pose in the middle alone, and must not be proven to hold it elsewhere."""
    box = _box(path)
    centre = cubic(box, np.array([(box.first + box.last) / 2.0]))
    still = Box(box.first, box.last, np.vstack([centre, np.zeros((3, 6))]), np.full(6, 1e-4))
    proven = include(geometry(path.machine), along(geometry(path.machine), pieces(path.spline)[0], still), still)
    assert proven is None or (deviations(path, proven.box) <= proven.box.radius).all()


def witness_curvature(path: Path) -> None:
    """A box as large as a radian is not proven by the Jacobian along its middle alone."""
    box = replace(_box(path), radius=np.full(6, 1.0))
    assert include(geometry(path.machine), along(geometry(path.machine), pieces(path.spline)[0], box), box) is None


def witness_uncertainty(path: Path) -> None:
    """With lengths wrong by two centimetres this machine cannot be proven to follow the path."""
    box = _box(path)
    series = along(geometry(path.machine), pieces(path.spline)[0], box)
    assert include(geometry(path.machine), series, box, Uncertainty(0.02)) is None


def witness_kappa(path: Path) -> None:
    """The bound of kappa is above every sample of a box."""
    box, series = _whole(path)
    bound = kappa.kappa_bound(geometry(path.machine), series, [arb(1e-9)] * 6)  # type: ignore[arg-type]
    s = samples_in(box)
    assert bound.kappa >= condition_number(statics_matrix(path.machine, path.pose(s), path.q(s)[:, :3])).max()


def witness_deviation(path: Path) -> None:
    """Kappa at a pose a centimetre off is within the bound for poses that may be that far off."""
    box, series = _whole(path)
    off = 0.01
    bound = kappa.kappa_bound(geometry(path.machine), series, [arb(off)] * 6)  # type: ignore[arg-type]
    s, worst = samples_in(box), 0.0
    for signs in np.array(np.meshgrid(*[[-1.0, 1.0]] * 6)).reshape(6, -1).T:
        pose = path.pose(s) + off * signs
        worst = max(worst, float(condition_number(statics_matrix(path.machine, pose, path.q(s)[:, :3])).max()))
    assert bound.kappa >= worst


def witness_distance(path: Path) -> None:
    """Bounds of distances are below every sample of a box."""
    box, series = _whole(path)
    pairs = clearance.build_pairs(path.machine)
    bounds = clearance.distance_bounds(geometry(path.machine), pairs, series, [arb(1e-9)] * 6)  # type: ignore[arg-type]
    s = samples_in(box)
    assert (bounds <= link_distances(path.machine, path.pose(s), path.q(s)[:, :3]).min(axis=0) + ROUNDING).all()


def witness_ranges(path: Path) -> None:
    """What a polynomial reaches between samples counts."""
    coefficients = [arb(0), arb(1), arb(0), arb(-1)]
    _, largest = ranges.polynomial_range(coefficients, arb(1))
    assert largest > arb(3).sqrt() * 2 / 9


def witness_rounding_of_bounds(path: Path) -> None:
    """A float that is to be above a ball is above it, even by less than a rounding."""
    value = arb(1) / 3 + arb(2) ** -60
    for k in range(1, 60):
        assert arb(kappa.above(value / k)) > value / k


def witness_rounding_of_sums(path: Path) -> None:
    """A sum in floats is off by its rounding."""
    total = enclosure.exactly(0.1) + enclosure.exactly(0.2)
    off = abs(Fraction(0.1) + Fraction(0.2) - Fraction(float(total.mid)))
    assert off <= Fraction(float(total.rad))


def witness_links(path: Path) -> None:
    """A box does not hold a joint that is beside it."""
    balls, piece, box = geometry(path.machine), pieces(path.spline)[0], _box(path)
    proven = include(balls, along(balls, piece, box), box)
    joint, _ = prove_joint(balls, path, piece, box.last, CERTAIN)
    assert proven is not None
    assert joint is not None
    assert holds(proven, joint)
    beside = replace(joint, box=replace(joint.box, pose=joint.box.pose + 2.0 * proven.box.radius))
    assert not holds(proven, beside)


def witness_order(path: Path) -> None:
    """Boxes follow one another without a gap."""
    chain = close_chain(geometry(path.machine), path, pieces(path.spline), 1e-6, examine_nothing)
    boxes = [proven.box for proven in chain.inclusions]
    assert boxes[0].first == 0.0
    assert boxes[-1].last == 1.0
    assert all(box.last == after.first for box, after in pairwise(boxes))


def _at_the_middle(coefficients: list[arb], at: arb) -> arb_series:
    """Take a sample in the place of an enclosure."""
    return closure.shifted(coefficients, arb(0))


def _no_last_term(C: object, series: object, h: arb) -> list[arb]:
    """Leave the residual out that the whole interval has."""
    return [arb(0)] * 6


BROKEN: dict[str, tuple[Callable[[Path], None], str, object]] = {
    "the residual is sampled": (witness_residual, "pipeline.certify.inclusion._residual", _no_last_term),
    "series are taken about the middle, not about the interval": (
        witness_kappa,
        "pipeline.certify.kappa.residual_of_inverse",
        lambda C, J, h: [[arb(0)] * 6] * 6,
    ),
    "the Jacobian is taken for constant": (
        witness_curvature,
        "pipeline.certify.inclusion.second_derivatives",
        lambda hull: [[arb(0)] * 36] * 6,
    ),
    "what the parameters change is left out": (
        witness_uncertainty,
        "pipeline.certify.inclusion.residual_change",
        lambda *given: [arb(0)] * 6,
    ),
    "poses are taken to be on the cubic": (
        witness_deviation,
        "pipeline.certify.kappa.statics_change",
        lambda *given: arb(0),
    ),
    "distances are taken in the middle": (
        witness_distance,
        "pipeline.certify.clearance._end_points",
        lambda pairs, series: [
            table if order == 0 else 0 * table for order, table in enumerate(_END_POINTS(pairs, series))
        ],
    ),
    "ranges are taken at samples": (
        witness_ranges,
        "pipeline.certify.ranges.polynomial_range",
        lambda coefficients, half: (arb(0), max(t - t**3 for t in (arb(k) / 16 for k in range(17)))),
    ),
    "a bound is rounded to nearest": (witness_rounding_of_bounds, "pipeline.certify.kappa.above", float),
    "a rounding is dropped": (witness_rounding_of_sums, "pipeline.certify.recheck.enclosure._U", 0.0),
    "neighbours are not compared": (witness_links, "tests.certify.test_mutations.holds", lambda *given: True),
}
_END_POINTS = clearance._end_points


@pytest.mark.parametrize("step", BROKEN)
def test_a_broken_step_is_noticed(line: Path, monkeypatch: pytest.MonkeyPatch, step: str) -> None:
    """The witness holds, and fails once the step is broken."""
    witness, target, broken = BROKEN[step]
    with working_precision(64):
        witness(line)
        monkeypatch.setattr(target, broken)
        with pytest.raises(AssertionError):
            witness(line)


def test_an_unbroken_chain_has_no_gap(line: Path) -> None:
    """Whatever else is proven, it is proven for every s."""
    with working_precision(64):
        witness_order(line)


def test_series_about_an_interval_hold_all_of_it(line: Path) -> None:
    """A cubic about a ball holds the cubic at any s of it; taken at its middle it does not."""
    pose = np.arange(24.0).reshape(4, 6) / 7.0
    with working_precision(64):
        over = [series[0] for series in pose_series(pose, arb(0, 0.25))]
        for t in np.linspace(-0.25, 0.25, 9):
            values = np.array([t**k for k in range(4)]) @ pose
            assert all(ball.overlaps(arb(float(value))) for ball, value in zip(over, values, strict=True))
        assert not over[0].is_exact()
        assert inclusion.LEAST_RADIUS > 0.0
