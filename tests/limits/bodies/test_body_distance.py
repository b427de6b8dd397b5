"""The limit of distances between bodies: words, readings, what could give, and its part of proofs."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import ConfigError
from pipeline.limits import admits, path_limits, pose_limits, relaxations, task_pose_limits
from pipeline.limits.bodies import body_distance
from pipeline.limits.bodies.surface_distance import SurfaceDistance
from pipeline.machine import Machine, build_machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import FrameKind, SweptHull
from pipeline.route.regions.endpoints import task_endpoints


def limit_of(machine: Machine) -> SurfaceDistance:
    """Build the limit of a machine with bodies."""
    (limit,) = body_distance.for_poses(machine, 100.0)
    assert isinstance(limit, SurfaceDistance)
    return limit


def test_machines_without_bodies_have_no_such_limit(agder_config: Config, machine: Machine) -> None:
    """Nor a measure, nor premises of certificates."""
    for limits in (
        pose_limits(machine, 100.0),
        path_limits(agder_config, machine),
        task_pose_limits(agder_config, machine),
    ):
        assert not any(isinstance(limit, SurfaceDistance) for limit in limits)
    assert body_distance.CERTIFICATE.premises(agder_config) == {}
    assert not body_distance.MEASURES[0].applies(machine)
    assert body_distance.relaxations(agder_config, machine) == []


def test_link_bodies_take_the_place_of_distances_of_axes(bodies_config: Config, bodies_machine: Machine) -> None:
    """Axes have no limit of their own then."""
    names = [limit.wording.name for limit in path_limits(bodies_config, bodies_machine)]
    assert "body distance" in names
    assert "link-link distance" not in names


def test_admitted_poses_have_no_margin_below_zero(bodies_machine: Machine, draw_poses) -> None:
    """By the quick way and by all distances."""
    drawn = draw_poses(bodies_machine, 6, 300)
    samples, limit = PoseSamples(bodies_machine, drawn.pose, drawn.q_m), limit_of(bodies_machine)
    np.testing.assert_array_equal(admits(limit, samples), (limit.margins(samples) >= 0.0).all(axis=1))
    np.testing.assert_allclose(limit.excess(samples), -limit.margins(samples))


def test_some_pairs_alone_have_the_distances_they_have_among_all(bodies_machine: Machine, draw_poses) -> None:
    """In the order in which they are asked for, without the hulls that none of them is of."""
    drawn, columns = draw_poses(bodies_machine, 6, 50), np.array([7, 2, 90])
    samples, limit = PoseSamples(bodies_machine, drawn.pose, drawn.q_m), limit_of(bodies_machine)
    some = limit.only(columns)
    np.testing.assert_array_equal(some.values(samples), limit.values(samples)[:, columns])
    assert some.bodies.names == tuple(limit.bodies.names[k] for k in columns.tolist())
    assert len(some.bodies.hulls) <= 2 * len(columns)


def test_what_is_too_close_is_named_worst_first(bodies_machine: Machine, draw_poses) -> None:
    """Three pairs at most, and how many more there are."""
    drawn = draw_poses(bodies_machine, 6, 300)
    samples, limit = PoseSamples(bodies_machine, drawn.pose, drawn.q_m), limit_of(bodies_machine)
    clear = samples.take(np.flatnonzero(admits(limit, samples))[:1])
    assert limit.violations(clear) == []
    limit = replace(limit, bodies=replace(limit.bodies, clearance_m=0.03))
    broken = (limit.margins(samples) < 0.0).sum(axis=1)
    row = int(broken.argmax())
    assert broken[row] > 3
    pose = samples.take(np.array([row]))
    found, distances = limit.violations(pose), body_distances(bodies_machine.bodies, pose)[0]
    assert len(found) == 3
    assert limit.bodies.names[int(distances.argmin())] in found[0]
    asked, advice = found[2].split("; ", 2)[1:]
    assert asked.endswith(f"({broken[row] - 3} more pairs are too close)")
    assert advice.startswith("move the pose, or one of these bodies")


def test_readings_name_the_nearest_pair(bodies_machine: Machine, draw_poses) -> None:
    """With its distance, however far it is."""
    drawn = draw_poses(bodies_machine, 7, 20)
    samples, limit = PoseSamples(bodies_machine, drawn.pose, drawn.q_m), limit_of(bodies_machine)
    distances = body_distances(bodies_machine.bodies, samples)
    (curve,) = limit.readings(samples)
    assert curve.name == f"body distance ({limit.bodies.names[int(distances[0].argmin())]})"
    np.testing.assert_array_equal(curve.values, distances.min(axis=1))
    np.testing.assert_array_equal(limit.curves(samples)[0].values, curve.values)


def test_a_start_in_collision_is_refused_with_the_pair(bodies_config: Config, bodies_machine: Machine, vary) -> None:
    """A ball of the platform, on link 2a 30 cm from its joint."""
    start, _ = task_endpoints(bodies_config, bodies_machine)
    frames = Frames.of(bodies_machine, start.samples.pose, start.samples.carts_m)
    place = SweptHull("place", FrameKind.LINK, 1, np.array([[1.0, -0.3]]), 0.0)
    centre = (frames.rotation[..., 0].T @ (frames.points(place)[0, :, 0] - start.pose[:3])).round(3).tolist()
    ball = {"name": "ball", "attached_to": "platform"}
    ball["capsule"] = {"from_m": centre, "to_m": centre, "radius_m": 0.03}
    config = vary(bodies_config, {"machine.bodies": [*bodies_config.model_dump()["machine"]["bodies"], ball]})
    with pytest.raises(ConfigError) as error:
        task_endpoints(config, build_machine(config.machine))
    issue = error.value.issues[0]
    assert issue.path == "task.start"
    assert issue.message.startswith("has ball and link 2a overlapping by 0.04")
    asked = "m or more; machine.clearance.bodies_m asks for 0.005 m; "
    assert issue.message.endswith(f"{asked}move the pose, or one of these bodies, or make it smaller")


def test_a_smaller_clearance_is_advised_where_nothing_overlaps(bodies_config: Config, vary) -> None:
    """With it the poses are admitted."""
    config = vary(bodies_config, {"machine.clearance.bodies_m": 0.02})
    with pytest.raises(ConfigError) as error:
        task_endpoints(config, build_machine(config.machine))
    advice = "; move the pose, or one of these bodies, or make it smaller, or lower machine.clearance.bodies_m"
    assert [issue.path for issue in error.value.issues if issue.message.endswith(advice)] == ["task.start", "task.goal"]
    config = vary(bodies_config, {"machine.clearance.bodies_m": 0.0055})
    task_endpoints(config, build_machine(config.machine))


def test_distances_bodies_and_each_body_could_give(bodies_config: Config, bodies_machine: Machine) -> None:
    """Each alone is tried only if all together help."""
    found = {one.key: one for one in relaxations(bodies_config, bodies_machine)}
    assert found["machine.clearance.bodies_m"].levels[[0, -1]].tolist() == [0.005, 0.0]
    assert found["machine.bodies[7]"].part_of == "machine.bodies"
    without_nose = found["machine.bodies[7]"].change(1.0)
    assert "nose" not in {body.name for body in without_nose.machine.bodies}
    assert found["machine.bodies"].change(1.0).machine.bodies == ()


def test_premises_are_the_declared_bodies(bodies_config: Config, vary) -> None:
    """Another radius, and the certificate is of another machine."""
    other = vary(bodies_config, {"machine.bodies.7.capsule.radius_m": 0.021})
    premises = [body_distance.CERTIFICATE.premises(config) for config in (bodies_config, other)]
    assert premises[0] != premises[1]
    assert set(premises[0]["bodies"]) == {"bodies", "link_bodies"}
