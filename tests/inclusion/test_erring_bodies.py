"""Bounds of bodies and joints for all errors of the actuators: never passed by a sample, and sharp to first order."""

import itertools
from dataclasses import dataclass

import numpy as np
import pytest

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic import inclusion as again
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.erring import erring
from pipeline.certify.recheck.claims.distances.body_distances import body_distance_bounds as bodies_again
from pipeline.certify.recheck.claims.joints.angles import joint_cosines as cosines_again
from pipeline.config import Config
from pipeline.inclusion.bounds import joint_cosine
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.distances.bodies import body_distance_bounds
from pipeline.inclusion.krawczyk import along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import of_actuators
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.limits.joint_cone import joint_cosines
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies
from pipeline.refine import Path
from tests.certify.paths import START, pose_path
from tests.joints import every_cone, with_cones
from tests.rails import off_x

_CORNERS = np.array(list(itertools.product([-1.0, 1.0], repeat=5)))
_NEAR = 0.3


@dataclass(frozen=True, eq=False)
class Case:
    """A machine with bodies and cones, a path, and a workpiece near it."""

    machine: Machine
    path: Path
    obstacles: Bodies

    @property
    def all_pairs(self) -> tuple[Bodies, Bodies]:
        """Bodies among themselves, and with the workpiece."""
        assert self.machine.bodies is not None
        return self.machine.bodies, self.obstacles


@dataclass(frozen=True, eq=False)
class Found:
    """Bounds in both arithmetics and the worst of samples: distances of all pairs, and cosines of all joints."""

    distances_m: np.ndarray
    distances_again_m: np.ndarray
    sampled_m: np.ndarray
    cosines: np.ndarray
    cosines_again: np.ndarray
    sampled_cosines: np.ndarray


@pytest.fixture(scope="module")
def case(bodies_config: Config, bodies_machine: Machine, vary) -> Case:
    """Go a short way; all joints have cones, about different axes."""
    box = {"centre_m": [1.05, 0.33, 0.45], "size_m": [0.2, 0.1, 0.1], "rounding_m": 0.01}
    obstacles = obstacles_of(vary(bodies_config, {"task.obstacles": [{"name": "workpiece", "box": box}]}))
    assert obstacles is not None
    machine = with_cones(bodies_machine, *every_cone(90.0))
    path = pose_path(machine, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 41), 0)
    return Case(machine, path, obstacles)


def bounded(case: Case, weights: np.ndarray, eps: float) -> Found:
    """Bound everything over a box, a tenth of the first piece."""
    machine, path, kind = case.machine, case.path, of_actuators(weights)(eps)
    with working_precision(64):
        piece = pieces(path.spline)[0]
        box = guess_box(path, piece.first, piece.first + 0.1 * (piece.last - piece.first))
        assert box is not None
        balls = geometry(machine)
        series = along(balls, piece, box)
        inclusion = include(balls, series, box, kind)
        assert inclusion is not None
        proven = ProvenBox(machine, balls, piece, series, inclusion)
        distances = [body_distance_bounds(proven, bodies) for bodies in case.all_pairs]
        cosines = [joint_cosine(proven, cone)[0] for cone in machine.joint_cones]
    boxes = again.build_boxes(machine, path, (inclusion.box,))
    found = again.include(machine, boxes, kind)
    assert found.proven.all()
    off = of_pose(machine, found.image), erring(machine, boxes, found)
    samples = _samples(case, (inclusion.box.first, inclusion.box.last), eps * weights)
    return Found(
        np.concatenate(distances),
        np.concatenate([bodies_again(machine, bodies, boxes, off)[:, 0] for bodies in case.all_pairs]),
        np.concatenate([body_distances(bodies, samples).min(axis=0) for bodies in case.all_pairs]),
        np.array(cosines),
        cosines_again(machine, boxes, *off)[:, 0],
        np.array([joint_cosines(cone, samples).min() for cone in machine.joint_cones]),
    )


def _samples(case: Case, ends: tuple[float, float], errors_m: np.ndarray) -> PoseSamples:
    """Evaluate all corners and some errors between them, at several s."""
    s = np.linspace(*ends, 3)
    errors = errors_m * np.concatenate([_CORNERS, np.random.default_rng(1).uniform(-1.0, 1.0, (8, 5))])
    q = (case.path.q(s)[:, None] + errors).reshape(-1, 5)
    pose, miss = newton(case.machine, q, np.repeat(case.path.pose(s), len(errors), axis=0))
    assert (miss < 1e-9).all()
    return PoseSamples(case.machine, pose, q)


@pytest.fixture(scope="module")
def found(case: Case) -> dict[str, Found]:
    """Bound everything without errors, with errors of all actuators, and of telescopes alone."""
    telescopes = np.array([0.0, 0.0, 0.0, 1.0, 0.3])
    asked = {"none": (1.0, 0.0), "little": (1.0, 2e-4), "all": (1.0, 1e-3), "telescopes": (telescopes, 3e-3)}
    return {name: bounded(case, weights * np.ones(5), eps) for name, (weights, eps) in asked.items()}


def test_no_sample_passes_a_bound(found: dict[str, Found]) -> None:
    """In either arithmetic: of capsules, boxes, tubes, beams, links cut short, an obstacle, and every joint."""
    for one in found.values():
        assert (np.maximum(one.distances_m, one.distances_again_m) <= one.sampled_m).all()
        assert (np.maximum(one.cosines, one.cosines_again) <= one.sampled_cosines).all()


def test_no_sample_passes_a_bound_on_rails_off_x(ends_machine: Machine) -> None:
    """Nor of bodies at ends of links there."""
    machine = with_cones(off_x(ends_machine), *every_cone(90.0))
    assert machine.obstacles is not None
    path = pose_path(machine, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 41), 0)
    one = bounded(Case(machine, path, machine.obstacles), np.ones(5), 1e-3)
    assert (np.maximum(one.distances_m, one.distances_again_m) <= one.sampled_m).all()
    assert (np.maximum(one.cosines, one.cosines_again) <= one.sampled_cosines).all()
    near = (one.sampled_m > 0.02) & (one.sampled_m < _NEAR)
    assert near.sum() > 10
    assert (one.distances_m >= one.sampled_m - 0.01)[near].mean() > 0.9


def test_bounds_are_sharp_to_first_order(found: dict[str, Found]) -> None:
    """What errors take in the bounds is near what they take at samples, but where closest points jump."""
    none, some = found["none"], found["little"]
    near = (none.sampled_m > 0.0) & (none.sampled_m < _NEAR)
    closer, by_sample = none.distances_m - some.distances_m, none.sampled_m - some.sampled_m
    ratio = closer[near] / np.maximum(by_sample[near], 1e-4)
    assert near.sum() > 10
    assert np.median(ratio) < 1.2
    assert np.quantile(ratio, 0.9) < 2.5
    turned = (none.cosines - some.cosines) / (none.sampled_cosines - some.sampled_cosines)
    assert (turned < 1.5).all()


def test_both_arithmetics_agree(found: dict[str, Found]) -> None:
    """To what the proof adds for that."""
    for one in found.values():
        proven = one.distances_m > 0.0
        assert (one.distances_again_m >= one.distances_m - 5e-5)[proven].all()
        assert (one.cosines_again >= one.cosines - 1e-6).all()
