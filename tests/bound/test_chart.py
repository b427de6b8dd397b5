"""Tests of the chart: it agrees with the poses of all working modes, and refuses machines it does not cover."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.arrays import FloatArray
from pipeline.bound.chart import Chart, build_chart, chart_point, frame, links, why_no_chart
from pipeline.bound.forms import pairs
from pipeline.config import Config
from pipeline.machine.geometry import TELESCOPES, Machine, build_machine, link_vectors, platform_arms
from pipeline.route.regions.endpoints import task_endpoints


def test_link_vectors_are_those_of_the_pose(chart: Chart, reference: tuple[Machine, Any]):
    """At start and goal, in opposite working modes, all vectors, arms, lengths and carts are those of the machine."""
    machine, ends = reference
    for end in ends:
        point = chart_point(chart, end)[:, None]
        at = frame(chart, point, point)
        found = links(chart, at, point, point)
        v, q = link_vectors(machine, end.pose, end.q_m[:3]), end.q_m
        assert found.v.c[..., 0] == pytest.approx(v, abs=1e-12)
        assert found.arms.c[..., 0] == pytest.approx(platform_arms(machine, end.pose), abs=1e-12)
        assert found.squares.c[:, 0] == pytest.approx((v[TELESCOPES] ** 2).sum(axis=1), abs=1e-12)
        assert found.apart.c[:, 0] == pytest.approx([q[0] - q[2], q[1] - q[2], q[0] - q[1]], abs=1e-12)
        assert found.ties.c[:, 0] == pytest.approx(0.0, abs=1e-12)


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
    x = np.divide(point - middle, half)
    i, j = pairs(6)
    for form, true in (
        (found.v, v.transpose(1, 2, 0)),
        (found.arms, platform_arms(machine, pose).transpose(1, 2, 0)),
        (found.squares, (v[:, TELESCOPES] ** 2).sum(axis=2).T),
        (found.apart, np.stack([carts[:, 0], carts[:, 1], carts[:, 0] - carts[:, 1]])),
    ):
        near = form.c + np.einsum("k...n,kn->...n", form.g, x) + np.einsum("k...n,kn->...n", form.q, x[i] * x[j])
        assert (np.abs(true - near) <= form.e + 1e-12).all()
    assert ((found.ties.lower <= 0.0) & (found.ties.upper >= 0.0)).all()


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
