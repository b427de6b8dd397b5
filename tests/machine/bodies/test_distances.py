"""Distances of the bodies of a machine: against sampled surfaces, axes, and moved along X."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import are_clear, body_distances, least_distance, least_distances
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.clearance import link_pairs
from pipeline.machine.samples import PoseSamples


@pytest.fixture(scope="module")
def samples(bodies_machine: Machine, draw_poses) -> PoseSamples:
    """Draw poses of the machine with bodies."""
    drawn = draw_poses(bodies_machine, 5, 400)
    return PoseSamples(bodies_machine, drawn.pose, drawn.q_m)


def test_no_points_of_two_hulls_are_nearer(bodies_machine: Machine, samples: PoseSamples) -> None:
    """Random points of both hulls are at least as far apart, and some nearly as near where they do not overlap."""
    rng, few = np.random.default_rng(1), samples.take(np.arange(4))
    bodies = bodies_machine.bodies
    assert bodies is not None
    found = body_distances(bodies_machine.bodies, few)
    frames = Frames.of(bodies_machine, few.pose, few.carts_m)
    for k in range(0, len(bodies.pairs), 7):
        pair = bodies.pairs[k]
        clouds = []
        for number in pair:
            points = frames.points(bodies.hulls[number])
            weights = np.vstack([np.eye(len(points)), rng.dirichlet(np.full(len(points), 0.5), 300)])
            clouds.append(np.einsum("wk,kcn->ncw", weights, points))
        if bodies.is_endless(pair):
            clouds = [cloud[:, 1:] for cloud in clouds]
        between = np.linalg.norm(clouds[0][..., None] - clouds[1][:, :, None], axis=1).min(axis=(1, 2))
        gap = between - bodies.radii_m(pair) - found[:, k]
        assert (gap >= -1e-9).all()
        assert (gap[found[:, k] > -bodies.radii_m(pair) + 1e-9] < 0.12).all()


def test_rods_are_as_far_apart_as_their_axes_less_their_radii(bodies_machine: Machine, samples: PoseSamples) -> None:
    """Whole links that share no joint: the distances of axes, which other code computes."""
    bodies = bodies_machine.bodies
    assert bodies is not None
    found = body_distances(bodies_machine.bodies, samples)
    name = "rod 2b and rod 3b"
    axes = samples.link_distances_m[:, link_pairs(bodies_machine).index((2, 4))]
    np.testing.assert_allclose(found[:, bodies.names.index(name)], axes - 0.03, atol=1e-12)


def test_moving_everything_along_x_changes_nothing(bodies_machine: Machine, samples: PoseSamples) -> None:
    """Rails and floor are endless."""
    pose, q = samples.pose.copy(), samples.q_m.copy()
    pose[:, 0] += 0.7
    q[:, :3] += 0.7
    moved = body_distances(bodies_machine.bodies, PoseSamples(bodies_machine, pose, q))
    np.testing.assert_allclose(moved, body_distances(bodies_machine.bodies, samples), atol=1e-9)


def test_beyond_the_reach_distances_count_as_the_reach(bodies_machine: Machine, samples: PoseSamples) -> None:
    """What is nearer is exact."""
    exact = body_distances(bodies_machine.bodies, samples)
    np.testing.assert_allclose(
        body_distances(bodies_machine.bodies, samples, 0.08), np.minimum(exact, 0.08), atol=1e-11
    )


def test_clear_poses_are_those_whose_pairs_all_keep_their_distance(
    bodies_machine: Machine, samples: PoseSamples
) -> None:
    """In whatever order pairs are tried, in blocks or not."""
    many = samples.take(np.tile(np.arange(len(samples)), 3_000 // len(samples) + 1))
    assert bodies_machine.bodies is not None
    expected = (body_distances(bodies_machine.bodies, many) >= bodies_machine.bodies.clearance_m).all(axis=1)
    np.testing.assert_array_equal(are_clear(bodies_machine.bodies, many), expected)
    assert 0.1 < expected.mean() < 0.9


def test_the_order_of_bodies_plays_no_role(bodies_machine: Machine, draw_poses) -> None:
    """Pairs of the other way round are as far apart."""
    drawn = draw_poses(bodies_machine, 8, 40)
    samples = PoseSamples(bodies_machine, drawn.pose, drawn.q_m)
    bodies = bodies_machine.bodies
    assert bodies is not None
    turned = replace(bodies, hulls=bodies.hulls[::-1], pairs=tuple((38 - j, 38 - i) for i, j in bodies.pairs))
    assert len(bodies.hulls) == 39
    other = body_distances(turned, samples)
    np.testing.assert_allclose(other, body_distances(bodies_machine.bodies, samples), atol=1e-9)


def test_no_poses_have_no_distances(bodies_machine: Machine) -> None:
    """An empty table is a table."""
    none = PoseSamples(bodies_machine, np.empty((0, 6)), np.empty((0, 5)))
    assert bodies_machine.bodies is not None
    assert body_distances(bodies_machine.bodies, none).shape == (0, len(bodies_machine.bodies.pairs))
    assert are_clear(bodies_machine.bodies, none).shape == (0,)


def test_spheres(quick_config: Config, vary, draw_poses) -> None:
    """A capsule without length keeps its radius from an axis in every direction."""
    ball = {"name": "ball", "attached_to": "platform"}
    ball["capsule"] = {"from_m": [0.0, 0.2, 0.3], "to_m": [0.0, 0.2, 0.3], "radius_m": 0.05}
    machine = build_machine(vary(quick_config, {"machine.bodies": [ball]}).machine)
    drawn = draw_poses(machine, 4, 30)
    samples = PoseSamples(machine, drawn.pose, drawn.q_m)
    assert machine.bodies is not None
    frames = Frames.of(machine, drawn.pose, drawn.q_m[:, :3])
    centre = frames.points(machine.bodies.hulls[0])[0].T
    joints, vectors = (np.moveaxis(part, -1, 0) for part in (frames.joints_m, frames.vectors_m))
    along = np.clip(np.einsum("nlc,nlc->nl", centre[:, None] - joints, vectors) / (vectors**2).sum(axis=2), 0.0, 1.0)
    expected = np.linalg.norm(joints + along[..., None] * vectors - centre[:, None], axis=2) - 0.05
    np.testing.assert_allclose(body_distances(machine.bodies, samples), expected, atol=1e-12)


def test_the_least_distances_are_those_of_all_pairs(bodies_machine: Machine, samples: PoseSamples) -> None:
    """At every pose, and at poses where nothing is near alone."""
    bodies = bodies_machine.bodies
    assert bodies is not None
    exact = body_distances(bodies, samples).min(axis=1)
    np.testing.assert_allclose(least_distances(bodies, samples), exact, atol=1e-11)
    for far in (0.0, 0.02):
        rows = np.flatnonzero(exact > far)
        assert 0 < len(rows) < len(samples)
        assert least_distance(bodies, samples.take(rows)) == pytest.approx(exact[rows].min(), abs=1e-11)
