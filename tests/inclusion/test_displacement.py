"""How far machines of an ellipsoid are off: ten thousand of them stay within, and some come near."""

from dataclasses import dataclass

import numpy as np
import pytest
from flint import arb

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic.calibrated import displacement as again
from pipeline.certify.recheck.arithmetic.inclusion import build_boxes
from pipeline.certify.recheck.arithmetic.inclusion import include as include_again
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.displacement import Displacement, of_pose
from pipeline.inclusion.krawczyk import Inclusion, along, include
from pipeline.inclusion.matrices import floats
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import Uncertainty
from pipeline.machine.geometry import ARM_OF_LINK
from pipeline.refine import Path
from tests.certify.possible import Machines, on_the_sphere, some_ellipsoid, towards

_NAMES = ("pose", "platform", "carts", "arms", "vectors", "lengths", "origins", "rails", "actuators")
_ELLIPSOID = some_ellipsoid(1e-4)


@dataclass(frozen=True, eq=False)
class Case:
    """A box that was proven for an ellipsoid, what is bounded over it, and what ten thousand machines do there."""

    inclusion: Inclusion
    bounds: dict[str, np.ndarray]
    checked: dict[str, np.ndarray]
    seen: dict[str, np.ndarray]
    apart: np.ndarray
    moves: np.ndarray


@pytest.fixture(scope="module")
def case(line: Path) -> Case:
    """Prove a box, and assemble machines at three s of it."""
    machine, piece = line.machine, pieces(line.spline)[0]
    box = guess_box(line, piece.first, piece.first + 0.05 * (piece.last - piece.first))
    assert box is not None
    uncertainty = Uncertainty(ellipsoid=_ELLIPSOID)
    with working_precision(64):
        balls = geometry(machine)
        series = along(balls, piece, box)
        inclusion = include(balls, series, box, uncertainty)
        assert inclusion is not None
        off = ProvenBox(machine, balls, piece, series, inclusion, _ELLIPSOID).displacement
        moves = np.array([floats(move) for move in off.moves])
    boxes = build_boxes(machine, line, (inclusion.box,))
    found = include_again(machine, boxes, uncertainty)
    assert found.proven.all()
    checked = again.of_machines(machine, boxes, found, _ELLIPSOID)
    u = np.concatenate(
        [on_the_sphere(_ELLIPSOID, 10_000), towards(_ELLIPSOID, moves.reshape(-1, moves.shape[-1])[18:36])]
    )
    seen: dict[str, np.ndarray] = {}
    for s, some in ((box.first, u), ((box.first + box.last) / 2.0, u[-1_000:]), (box.last, u[-1_000:])):
        for name, values in _off(line, s, some).items():
            seen[name] = np.maximum(seen.get(name, 0.0), values)
    return Case(
        inclusion,
        {name: _bounds(getattr(off, name)) for name in _NAMES},
        {name: getattr(checked, name)[:, 0] for name in _NAMES},
        seen,
        _apart(line, box.first, u[:500]),
        moves,
    )


def _bounds(values: list[arb]) -> np.ndarray:
    return np.array([float(value.upper()) for value in values])


def _off(path: Path, s: float, u: np.ndarray) -> dict[str, np.ndarray]:
    """Measure how far machines are off, the largest of all."""
    q, pose = path.q(s), path.pose(s)
    many, plain = (Machines.at(path.machine, _ELLIPSOID, part, q) for part in (u, 0.0 * u[:1]))
    poses, own = many.assembled(pose), pose[None]
    parts = {
        "arms": many.arms(poses) - plain.arms(own),
        "carts": many.joints - plain.joints,
        "vectors": many.vectors(poses) - plain.vectors(own),
        "platform": poses[:, None, :3] + many.arms(poses) - (own[:, None, :3] + plain.arms(own)),
        "rails": many.rails - plain.rails,
        "origins": np.concatenate([(many.actuators - plain.actuators)[:, :3, None], many.rails - plain.rails], axis=2),
    }
    found = {name: np.linalg.norm(part, axis=2).max(axis=0) for name, part in parts.items()}
    found["pose"] = np.abs(poses - own).max(axis=0)
    found["lengths"] = np.abs(many.lengths - plain.lengths).max(axis=0)
    found["actuators"] = np.abs(many.actuators - plain.actuators).max(axis=0)
    return found


def _apart(path: Path, s: float, u: np.ndarray) -> np.ndarray:
    """Give displacements of cart joints, platform joints and rails of every machine, less what is linear in u."""
    q, pose = path.q(s), path.pose(s)
    many, plain = (Machines.at(path.machine, _ELLIPSOID, part, q) for part in (u, 0.0 * u[:1]))
    poses, own = many.assembled(pose), pose[None]
    platform = poses[:, None, :3] + many.arms(poses) - (own[:, None, :3] + plain.arms(own))
    rails = np.concatenate([np.zeros((len(u), 3, 1)), many.rails - plain.rails], axis=2)
    return np.concatenate([many.joints - plain.joints, platform, rails], axis=1)


def test_no_machine_is_farther_off(case: Case) -> None:
    """Neither than what is proven, nor than what is checked."""
    for name in _NAMES:
        assert (case.seen[name] <= case.bounds[name]).all(), name
        assert (case.seen[name] <= case.checked[name]).all(), name


def test_bounds_are_hardly_larger_than_what_is_seen(case: Case) -> None:
    """Norms of matrices by Frobenius norms of their squares cost up to a third; the check is as sharp as the proof."""
    for name in _NAMES:
        assert (case.bounds[name] <= 2.0 * case.seen[name]).all(), name
        np.testing.assert_allclose(case.checked[name], case.bounds[name], rtol=0.1)


def test_end_points_move_as_the_matrices_say(case: Case) -> None:
    """To first order: what remains is hundreds of times smaller than the motion."""
    u = on_the_sphere(_ELLIPSOID, 10_000)[:500]
    linear = np.einsum("pcm,nm->npc", case.moves, u) / _ELLIPSOID.sigma
    assert np.abs(case.apart - linear).max() < 0.05 * np.abs(case.apart).max()


def test_a_pose_that_is_off_moves_joints_by_its_arms(line: Path) -> None:
    """Without an ellipsoid carts, rails and lengths stay."""
    with working_precision(64):
        off: Displacement = of_pose(geometry(line.machine), [arb(1e-3)] * 6)
    arms = np.linalg.norm(line.machine.platform_points_m, axis=1)
    np.testing.assert_allclose(_bounds(off.platform), 1e-3 * (np.sqrt(3.0) + 3.0 * arms), rtol=1e-9)
    assert not _bounds([*off.carts, *off.rails, *off.origins, *off.lengths]).any()
    assert len(off.vectors) == len(ARM_OF_LINK)
