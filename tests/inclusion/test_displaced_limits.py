"""Bounds of limits for all machines of an ellipsoid: never passed by a sample, in either arithmetic."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from pipeline.certify.guess import guess_box
from pipeline.certify.recheck.arithmetic import inclusion as again
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_machines
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.claims.controlled.avoided import measure as outside_again
from pipeline.certify.recheck.claims.distances.axis_distances import distance_bounds as distances_again
from pipeline.certify.recheck.claims.distances.body_distances import body_distance_bounds as bodies_again
from pipeline.certify.recheck.claims.joints.angles import joint_cosines as cosines_again
from pipeline.certify.recheck.claims.kappa import kappa_bounds as kappa_again
from pipeline.config import BoxConfig, Config
from pipeline.inclusion.bounds import joint_cosine
from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.condition import kappa_bound
from pipeline.inclusion.distances.avoidance import least_outside
from pipeline.inclusion.distances.axes import AxisPairs, distance_bounds
from pipeline.inclusion.distances.bodies import body_distance_bounds
from pipeline.inclusion.krawczyk import along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.limits.avoid import Box
from pipeline.limits.joint_cone import joint_cosines
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.clearance import link_distances, link_pairs, link_rail_distances, rail_pairs
from pipeline.machine.geometry import ARM_OF_LINK
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies
from pipeline.refine import Path
from tests.certify.paths import START, pose_path
from tests.certify.possible import Machines, on_the_sphere, some_ellipsoid
from tests.joints import every_cone, with_cones
from tests.rails import off_x

_MANY = 25
_AVOID = (
    {"y_m": [0.0, 0.2], "rx_deg": [-20.0, 20.0]},
    {"rx_deg": [5.0, 9.0]},
    {"x_m": [0.5, 1.3], "z_m": [0.9, 1.2], "rz_deg": [4.0, 8.0]},
)
"""Boxes near the path: of both kinds of coordinates."""


@dataclass(frozen=True, eq=False)
class Found:
    """Lower bounds in both arithmetics, and the least of samples.

    Of links, links and rails, bodies, those at ends of links among them, obstacles, cosines, boxes to avoid; kappa.

    `off` is how far the joints of each link may be off.
    """

    proven: dict[str, np.ndarray]
    checked: dict[str, np.ndarray]
    seen: dict[str, np.ndarray]
    off: np.ndarray


@pytest.fixture(scope="module")
def path(ends_machine: Machine) -> Path:
    """Go a short way with bodies, some of them at ends of links; all joints have cones."""
    machine = with_cones(ends_machine, *every_cone(90.0))
    return pose_path(machine, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 41), 0)


@pytest.fixture(scope="module")
def avoiding(ends_config: Config) -> Config:
    """Ask for boxes to avoid."""
    boxes = tuple(BoxConfig.model_validate(one) for one in _AVOID)
    return ends_config.model_copy(update={"task": ends_config.task.model_copy(update={"avoid": boxes})})


def _boxes() -> list[Box]:
    return [Box.of(BoxConfig.model_validate(one)) for one in _AVOID]


def _groups(machine: Machine) -> dict[str, Bodies]:
    assert machine.bodies is not None
    assert machine.obstacles is not None
    return {"bodies": machine.bodies, "obstacles": machine.obstacles}


def _bounded(path: Path, uncertainty: Uncertainty, config: Config) -> Found:
    """Bound everything over a box, a twentieth of the first piece."""
    machine, piece = path.machine, pieces(path.spline)[0]
    box = guess_box(path, piece.first, piece.first + 0.05 * (piece.last - piece.first))
    assert box is not None
    pairs = {"links": (link_pairs(machine), False), "rails": (rail_pairs(machine), True)}
    of = {name: AxisPairs.of(*both, machine) for name, both in pairs.items()}
    with working_precision(64):
        balls = geometry(machine)
        series = along(balls, piece, box)
        inclusion = include(balls, series, box, uncertainty)
        assert inclusion is not None
        one = ProvenBox(machine, balls, piece, series, inclusion, uncertainty.ellipsoid)
        proven = {name: distance_bounds(pair, series, one.displacement) for name, pair in of.items()}
        proven |= {name: body_distance_bounds(one, bodies) for name, bodies in _groups(machine).items()}
        proven["outside"] = np.array([least_outside(one, avoided.low, avoided.high) for avoided in _boxes()])
        proven["cosines"] = np.array([joint_cosine(one, cone)[0] for cone in machine.joint_cones])
        proven["kappa"] = np.array([-kappa_bound(balls, series, one.displacement).kappa])
    joints = zip(one.displacement.platform, one.displacement.carts, strict=True)
    moved = np.array([max(float(end.upper()) for end in both) for both in joints])
    boxes = again.build_boxes(machine, path, (inclusion.box,))
    found = again.include(machine, boxes, uncertainty)
    assert found.proven.all()
    ends = inclusion.box.first, inclusion.box.last
    if uncertainty.ellipsoid is None:
        return Found(
            proven, {}, _seen([PoseSamples(machine, path.pose(np.array(ends)), path.q(np.array(ends)))]), moved
        )
    off = of_machines(machine, boxes, found, uncertainty.ellipsoid), None
    checked = {name: distances_again(machine, pair, boxes, off)[:, 0] for name, pair in of.items()}
    checked |= {name: bodies_again(machine, bodies, boxes, off)[:, 0] for name, bodies in _groups(machine).items()}
    segment = EvaluatedChain(boxes, found, boxes, found, uncertainty.ellipsoid)
    checked["outside"] = outside_again(config, machine, segment)[:, 0]
    checked["cosines"] = cosines_again(machine, boxes, off[0])[:, 0]
    checked["kappa"] = -kappa_again(machine, boxes, off[0])[0]
    return Found(proven, checked, _seen(_samples(path, ends, uncertainty)), moved)


def _samples(path: Path, ends: tuple[float, float], uncertainty: Uncertainty) -> list[PoseSamples]:
    """Assemble machines on the sphere at both ends."""
    ellipsoid, machine, found = uncertainty.ellipsoid, path.machine, []
    assert ellipsoid is not None
    u = on_the_sphere(ellipsoid, _MANY)
    for s in ends:
        many = Machines.at(machine, ellipsoid, u, path.q(s))
        poses = many.assembled(path.pose(s))
        for k, pose in enumerate(poses):
            offsets = many.joints[k].copy()
            offsets[:, 0] -= many.actuators[k, ARM_OF_LINK]
            offsets[:, 1:] -= many.rails[k, ARM_OF_LINK]
            lengths = np.where(np.isnan(machine.lengths_m), np.nan, many.lengths[k])
            one = replace(
                machine,
                platform_points_m=many.points[k],
                cart_offsets_m=offsets,
                rails_m=many.rails[k],
                lengths_m=lengths,
            )
            found.append(PoseSamples(one, pose[None], many.actuators[k][None]))
    return found


def _seen(samples: list[PoseSamples]) -> dict[str, np.ndarray]:
    names = ("links", "rails", "bodies", "obstacles", "outside", "cosines", "kappa")
    found: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for one in samples:
        machine, carts = one.machine, one.q_m[:, :3]
        found["links"].append(link_distances(machine, one.pose, carts).min(axis=0))
        found["rails"].append(link_rail_distances(machine, one.pose, carts).min(axis=0))
        for name, bodies in _groups(machine).items():
            found[name].append(body_distances(bodies, one).min(axis=0))
        found["outside"].append(np.array([-box.depth_m(one.controlled).max() for box in _boxes()]))
        found["cosines"].append(np.array([joint_cosines(cone, one).min() for cone in machine.joint_cones]))
        found["kappa"].append(-one.kappa.max(keepdims=True))
    return {name: np.min(values, axis=0) for name, values in found.items()}


@pytest.fixture(scope="module")
def found(path: Path, avoiding: Config) -> Found:
    """Bound everything for machines that are off by some tenths of a millimetre."""
    return _bounded(path, Uncertainty(ellipsoid=some_ellipsoid(1e-4)), avoiding)


def test_no_machine_passes_a_bound(found: Found) -> None:
    """Of links, rails, bodies, obstacles, boxes to avoid, cones and kappa, in either arithmetic."""
    for name, seen in found.seen.items():
        assert (found.proven[name] <= seen + 1e-12).all(), name
        assert (found.checked[name] <= seen + 1e-12).all(), name


def test_both_arithmetics_agree(found: Found) -> None:
    """To what the proof adds for that."""
    slack = dict.fromkeys(("links", "rails", "bodies", "obstacles"), 5e-5) | {"outside": 1e-5, "cosines": 1e-6}
    slack["kappa"] = 0.01 * -found.proven["kappa"]
    for name, proven in found.proven.items():
        known = proven > 0.0 if name in ("bodies", "obstacles") else np.isfinite(proven)
        assert (found.checked[name] >= proven - slack[name])[known].all(), name


def test_distances_of_links_cost_less_than_their_joints_are_off(path: Path, avoiding: Config, found: Found) -> None:
    """As joints, lengths and encoders are taken together, and only along the line between both links."""
    none = _bounded(path, CERTAIN, avoiding)
    taken = none.proven["links"] - found.proven["links"]
    apart = np.array([found.off[a] + found.off[b] for a, b in link_pairs(path.machine)])
    assert (taken <= apart).all()
    assert np.median(taken / apart) < 0.9


def test_machines_whose_rails_are_off_x_are_refused(path: Path) -> None:
    """In either arithmetic: what they change of a machine is along X."""
    machine, uncertainty = off_x(path.machine, largest=1e-9), Uncertainty(ellipsoid=some_ellipsoid(1e-4))
    piece = pieces(path.spline)[0]
    box = guess_box(path, piece.first, piece.first + 0.05 * (piece.last - piece.first))
    assert box is not None
    balls = geometry(machine)
    with working_precision(64), pytest.raises(ValueError, match="rails along X"):
        include(balls, along(balls, piece, box), box, uncertainty)
    with pytest.raises(ValueError, match="rails along X"):
        again.include(machine, again.build_boxes(machine, path, (box,)), uncertainty)
