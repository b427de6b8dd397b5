"""Tests of the chart: it agrees with the poses of all working modes, and refuses machines it does not cover."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.bound.chart import Chart, build_chart, chart_point, frame, links, why_no_chart
from pipeline.config import Config
from pipeline.machine.geometry import Machine, build_machine, link_vectors, rotation
from pipeline.route.regions.endpoints import task_endpoints


def test_link_vectors_are_those_of_the_pose(chart: Chart, reference: tuple[Machine, Any]):
    """At start and goal, in opposite working modes, all six vectors agree in the platform's frame up to its turn."""
    machine, ends = reference
    for end in ends:
        point = chart_point(chart, end)[:, None]
        at = frame(chart, point, point)
        found = links(chart, at, point, point)
        world = at.P.c[..., 0] @ found.v.c[..., 0].T
        assert pytest.approx(link_vectors(machine, end.pose, end.q_m[:3]), abs=1e-12) == world.T
        assert found.carts.c[:, 0] == pytest.approx(end.q_m[:2] - end.q_m[2], abs=1e-12)
        assert found.mismatch.c[:, 0] == pytest.approx(0.0, abs=1e-12)


def test_every_pose_is_enclosed(
    chart: Chart,
    reference: tuple[Machine, Any],
    place: Callable[[Machine, FloatArray], tuple[FloatArray, FloatArray, FloatArray]],
):
    """Vectors of poses within random boxes lie within the forms, and s_k^2 - D_k = 0 is not excluded."""
    machine, rng = reference[0], np.random.default_rng(3)
    angles = rng.uniform([-0.2, -0.5, -0.5, -0.5], [3.3, 0.9, 0.5, 0.5], (300, 4)).T
    pose, joints, D = place(machine, angles)
    good = (D > 0.0).all(axis=0)
    angles, pose, joints, D = angles[:, good], pose[good], joints[good], D[:, good]
    s = -np.sqrt(D)
    point = np.vstack([angles, s])
    half = 10.0 ** rng.uniform(-4.0, -0.7, point.shape)
    middle = point + half * rng.uniform(-0.99, 0.99, point.shape)
    at = frame(chart, middle - half, middle + half)
    found = links(chart, at, middle - half, middle + half)
    carts = np.column_stack([joints[:, 0, 0] - s[0], joints[:, 1, 0] - s[1], np.zeros(len(pose))])
    v = link_vectors(machine, pose, carts)
    Q = rotation(pose[:, 3], np.zeros(len(pose)), pose[:, 5])
    P = Q @ rotation(np.zeros(len(pose)), -angles[0], np.zeros(len(pose)))
    true = np.einsum("nij,nli->ljn", P, v)
    assert (np.abs(true - found.v.c) <= found.v.radius + 1e-12).all()
    assert ((found.mismatch.lower <= 0.0) & (found.mismatch.upper >= 0.0)).all()


def test_fixed_tilts_have_no_coordinate(reference: tuple[Machine, Any]):
    """Locked tilts leave four coordinates, tied by two equations."""
    assert build_chart(reference[0], (0.0, 0.0), reference[1]).free == [0, 1, 4, 5]


def test_a_turned_machine_has_the_same_chart(
    quick_config: Config, vary: Callable[..., Config], reference: tuple[Machine, Any]
):
    """A platform frame that is turned about y changes nothing but the angle psi."""
    angle = 0.4
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    names = ("l1", "l2a", "l2b", "l3a", "l3b", "l3c")
    points = reference[0].platform_points_m @ turn.T
    config = vary(
        quick_config,
        {f"machine.links.{name}.platform_point_m": a.tolist() for name, a in zip(names, points, strict=True)},
    )
    machine = build_machine(config.machine)
    ends = task_endpoints(config, machine)
    turned = build_chart(machine, (0.5, 0.5), ends)
    plain = build_chart(reference[0], (0.5, 0.5), reference[1])
    assert turned.joints_m == pytest.approx(plain.joints_m, abs=1e-12)
    assert chart_point(turned, ends[0]) == pytest.approx(chart_point(plain, reference[1][0]), abs=1e-12)


@pytest.mark.parametrize(
    ("link", "point", "reason"),
    [(3, [0.01, 0.1, 0.0], "y axis"), (5, [0.13, 0.11, 0.0], "right angle to the platform's y axis")],
)
def test_other_machines_are_refused(reference: tuple[Machine, Any], link: int, point: list[float], reason: str):
    """What the chart does not cover is named."""
    points = reference[0].platform_points_m.copy()
    points[link] = point
    assert reason in why_no_chart(replace(reference[0], platform_points_m=points), right_angled=True)
    assert why_no_chart(reference[0], right_angled=True) == ""
    assert "no right angle" in why_no_chart(reference[0], right_angled=False)
