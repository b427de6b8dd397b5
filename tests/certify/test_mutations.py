"""Every rigorous step is needed: each one broken on purpose lets something wrong pass, and that is noticed here.

A witness is a statement that holds as long as the steps are rigorous. It is run as it is, and with a step broken.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from flint import arb, fmpq, fmpq_poly
from scipy.interpolate import BSpline

from pipeline.certify.chain import close_chain
from pipeline.certify.guess import guess_box
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck.arithmetic import enclosure
from pipeline.certify.result import proven_chain
from pipeline.config.file import load_config
from pipeline.inclusion import bounds, condition, growth
from pipeline.inclusion.closure import geometry, pose_series, shifted, working_precision
from pipeline.inclusion.displacement import of_pose
from pipeline.inclusion.distances import axes
from pipeline.inclusion.krawczyk import Box, Inclusion, Piecewise, along, include
from pipeline.inclusion.pieces import Piece, pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.machine import condition_number, link_distances, statics_matrix
from pipeline.machine.clearance import link_pairs
from pipeline.machine.kinematics import closure_jacobian
from pipeline.refine import Path
from tests.certify.audit import ROUNDING, cubic, deviations, samples_in
from tests.certify.paths import Jumping, branching_chains, torn, two_branches, verified
from tests.conftest import CONFIGS

CONFIG = load_config(CONFIGS / "agder.yaml")


def _box(path: Path) -> Box:
    found = guess_box(path, 0.0, pieces(path.spline)[0].last)
    assert found is not None
    return found


def _whole(path: Path) -> tuple[Box, Piecewise]:
    """Widen the path's first piece to a fast one: poses that hardly move hide what is missing."""
    box = _box(path)
    return box, along(geometry(path.machine), pieces(path.spline)[0], box)


def _proven(path: Path, piece: Piece) -> ProvenBox:
    """Take a box over a whole piece for proven, at a pose of zeros."""
    balls, box = geometry(path.machine), Box(piece.first, piece.last, np.zeros((4, 6)), np.full(6, 1.0))
    inclusion = Inclusion(box, np.zeros((2, 6, 6)), [arb(0)] * 6, [arb(0)] * 6, [])
    return ProvenBox(path.machine, balls, piece, along(balls, piece, box), inclusion)


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
    (box, series), balls = _whole(path), geometry(path.machine)
    bound = condition.kappa_bound(balls, series, of_pose(balls, [arb(1e-9)] * 6))
    s = samples_in(box)
    assert bound.kappa >= condition_number(statics_matrix(path.machine, path.pose(s), path.q(s)[:, :3])).max()


def witness_deviation(path: Path) -> None:
    """Kappa at a pose a centimetre off is within the bound for poses that may be that far off."""
    (box, series), balls = _whole(path), geometry(path.machine)
    off = 0.01
    bound = condition.kappa_bound(balls, series, of_pose(balls, [arb(off)] * 6))
    s, worst = samples_in(box), 0.0
    for signs in np.array(np.meshgrid(*[[-1.0, 1.0]] * 6)).reshape(6, -1).T:
        pose = path.pose(s) + off * signs
        worst = max(worst, float(condition_number(statics_matrix(path.machine, pose, path.q(s)[:, :3])).max()))
    assert bound.kappa >= worst


def witness_distance(path: Path) -> None:
    """Bounds of distances are below every sample of a box."""
    box, series = _whole(path)
    pairs = axes.AxisPairs.of(link_pairs(path.machine), False, path.machine)
    least = axes.distance_bounds(pairs, series, of_pose(geometry(path.machine), [arb(1e-9)] * 6))
    s = samples_in(box)
    assert (least <= link_distances(path.machine, path.pose(s), path.q(s)[:, :3]).min(axis=0) + ROUNDING).all()


def witness_ranges(path: Path) -> None:
    """What an actuator does between the middle of a box and its ends is within its bounds."""
    bend = fmpq_poly([1, 0, fmpq(1, 100)])
    ranges = bounds.actuator_ranges(_proven(path, Piece(0.0, 1.0, (bend,) * 5)))
    assert (ranges[:, 1] >= 1.01).all()


def witness_rounding_of_bounds(path: Path) -> None:
    """A bound is above what it bounds, even by less than a rounding."""
    for k in range(1, 60):
        value = fmpq(1, 3 * k) + fmpq(1, 2**60)
        box = _proven(path, Piece(0.0, 1.0, (fmpq_poly([value]),) * 5))
        above = float(bounds.actuator_ranges(box)[0, 1])
        assert Fraction(above) >= Fraction(int(value.p), int(value.q))


def witness_series(path: Path) -> None:
    """Series about an interval hold the Jacobian at every s of it."""
    box, series = _whole(path)
    balls = series.over.jacobian()
    for s in samples_in(box, 5):
        q, pose = path.q(s), cubic(box, np.array([s]))[0]
        lengths = np.linalg.norm(closure_jacobian(path.machine, pose, q)[:, :3], axis=1)
        J = closure_jacobian(path.machine, pose, q) / lengths[:, None]
        for row, found in zip(J, balls, strict=True):
            size = (found[0][0] ** 2 + found[1][0] ** 2 + found[2][0] ** 2).sqrt()
            assert all((ball[0] / size).overlaps(arb(value, 1e-12)) for value, ball in zip(row, found, strict=True))


def witness_rounding_of_sums(path: Path) -> None:
    """A sum in floats is off by its rounding."""
    total = enclosure.exactly(0.1) + enclosure.exactly(0.2)
    off = abs(Fraction(0.1) + Fraction(0.2) - Fraction(float(total.mid)))
    assert off <= Fraction(float(total.rad))


def witness_links(path: Path) -> None:
    """Two proven boxes on different branches make no chain, whichever of them holds the pose where they meet."""
    one, other = two_branches(path.machine, path)
    for before in (True, False):
        jumping = Jumping(one.machine, one.spline, one.node_s, one.node_pose, beyond=other, before=before)
        chain = close_chain(build_problem(path.machine, jumping, 0.3))
        assert chain.failure is not None


def witness_stored_links(path: Path) -> None:
    """A stored chain of two proven boxes on different branches is not verified."""
    for chain in branching_chains(path.machine, path):
        claims = verified(CONFIG, two_branches(path.machine, path)[0], chain)
        assert claims["each box holds one regular pose"]
        assert not claims["neighbouring boxes share a branch"]


def witness_jump(path: Path) -> None:
    """Actuators that jump are no path, however little they do."""
    jumping = replace(path, spline=torn(path.spline, 1e-13))
    chain = close_chain(build_problem(path.machine, jumping, 1e-2))
    assert chain.failure is not None


def witness_knots(path: Path) -> None:
    """A stored box that reaches across a knot is not verified: beyond it the splines do something else."""
    one, _ = two_branches(path.machine, path)
    bent = replace(one, spline=BSpline(one.spline.t, one.spline.c + [[0.0] * 5, [0.0] * 5, [0.1] * 5], 1))
    straight = replace(one, spline=BSpline([0.0, 0.0, 1.0, 1.0], one.spline.c[::2], 1))
    chain = close_chain(build_problem(path.machine, straight, 0.9))
    claims = verified(CONFIG, bent, proven_chain(chain, CERTAIN))
    assert claims["boxes cover s = 0 to 1"]
    assert not claims["each box holds one regular pose"]


def witness_order(path: Path) -> None:
    """Boxes follow one another without a gap."""
    chain = close_chain(build_problem(path.machine, path, 1e-6))
    boxes = [proven.box for proven in chain.inclusions]
    assert boxes[0].first == 0.0
    assert boxes[-1].last == 1.0
    assert all(box.last == after.first for box, after in pairwise(boxes))


def _no_last_term(C: object, series: object, h: arb) -> list[arb]:
    """Leave the residual out that the whole interval has."""
    return [arb(0)] * 6


@dataclass(frozen=True)
class Broken:
    """A step of the proof, where it is called from, and what is put in its place; and what notices."""

    witness: Callable[[Path], None]
    steps: dict[str, object]


BROKEN: dict[str, Broken] = {
    "the residual is sampled": Broken(witness_residual, {"inclusion.krawczyk._residual": _no_last_term}),
    "series are taken about the middle, not about the interval": Broken(
        witness_series,
        {
            "inclusion.krawczyk.pose_series": lambda pose, at: pose_series(pose, arb(0)),
            "inclusion.krawczyk.shifted": lambda coefficients, at: shifted(coefficients, arb(0)),
        },
    ),
    "what an approximate inverse misses is left out": Broken(
        witness_kappa, {"inclusion.condition.residual_of_inverse": lambda C, J, h: [[arb(0)] * 6] * 6}
    ),
    "the Jacobian is taken for constant": Broken(
        witness_curvature, {"inclusion.growth.second_derivatives": lambda hull: [[arb(0)] * 36] * 6}
    ),
    "what the parameters change is left out": Broken(
        witness_uncertainty, {"inclusion.krawczyk.residual_change": lambda *given: [arb(0)] * 6}
    ),
    "poses are taken to be on the cubic": Broken(
        witness_deviation, {"inclusion.condition.statics_change": lambda *given: arb(0)}
    ),
    "distances are taken in the middle": Broken(
        witness_distance,
        {
            "inclusion.distances.axes._end_points": lambda pairs, series: [
                table if order == 0 else 0 * table for order, table in enumerate(_END_POINTS(pairs, series))
            ]
        },
    ),
    "ranges are taken in the middle": Broken(
        witness_ranges,
        {"inclusion.bounds.polynomial_range": lambda coefficients, half: (coefficients[0], coefficients[0])},
    ),
    "a bound is rounded to nearest": Broken(
        witness_rounding_of_bounds, {"inclusion.bounds.above": lambda value: float(value.upper())}
    ),
    "neighbours are not compared": Broken(witness_links, {"certify.chain.holds": lambda *given: True}),
    "a jump is not looked for": Broken(witness_jump, {"certify.chain._discontinuity": lambda *given: None}),
    "a rounding is dropped": Broken(witness_rounding_of_sums, {"certify.recheck.arithmetic.enclosure._U": 0.0}),
    "stored neighbours are not compared": Broken(
        witness_stored_links,
        {"certify.recheck.claims.chain.holds": lambda boxes, *given, at_end: np.ones(len(boxes.first), bool)},
    ),
    "knots are passed over": Broken(
        witness_knots,
        {"certify.recheck.arithmetic.inclusion.on_one_piece": lambda spline, first, last: np.ones(len(first), bool)},
    ),
}
_END_POINTS = axes._end_points


@pytest.mark.parametrize("step", BROKEN)
def test_a_broken_step_is_noticed(line: Path, monkeypatch: pytest.MonkeyPatch, step: str) -> None:
    """The witness holds, and fails once the step is broken where it is called from."""
    broken, called = BROKEN[step], set()

    def counted(name: str, replacement: object) -> object:
        if not callable(replacement):
            return replacement

        def call(*given: object, **named: object) -> object:
            called.add(name)
            return replacement(*given, **named)

        return call

    with working_precision(64):
        broken.witness(line)
        for name, replacement in broken.steps.items():
            monkeypatch.setattr(f"pipeline.{name}", counted(name, replacement))
        with pytest.raises(AssertionError):
            broken.witness(line)
    assert called == {name for name, replacement in broken.steps.items() if callable(replacement)}


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
        assert growth.LEAST_RADIUS > 0.0
