"""Cones around the straight ends of a path."""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.certify import certify_path
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.refine import Refinement, refine_path
from pipeline.refine.check import find_violations
from pipeline.refine.corridor.cone import StraightEnd, straight_ends, walls_at
from pipeline.refine.mesh import even_mesh, with_straight_ends
from pipeline.route import Route, build_regions, plan_route

Vary = Callable[[Config, dict[str, object]], Config]
END = StraightEnd("goal", np.array([1.0, 0.3, 0.9, 0.1, 0.0, 0.0]), np.array([0.6, 0.0, 0.8]), 7, 1.0, 0.9)


def test_walls_are_within_the_cone_and_touch_two_thirds_of_it() -> None:
    """Whatever is behind all walls is within 3 degrees of the line, and all within 2 degrees is behind them."""
    s = np.array([0.0, 0.9, 0.95, 1.0])
    walls = walls_at([END], s)
    assert set(walls.node.tolist()) == {2}
    rng = np.random.default_rng(3)
    along = rng.uniform(0.0, 0.05, 4_000)[:, None] * END.outward
    away = along + rng.normal(scale=0.002, size=(4_000, 3))
    angle = np.rad2deg(np.arctan2(np.linalg.norm(np.cross(END.outward, away), axis=1), away @ END.outward))
    behind = ((END.end[:3] + away) @ walls.normal.T <= walls.offset).all(axis=1)
    assert behind.any()
    assert angle[behind].max() < 2.2
    assert behind[angle < 2.0].all()


def test_the_excess_is_in_metres_across_and_radians_of_tilt() -> None:
    """Zero at the end itself; positive outside the cone, and tilted by more than a degree."""
    pose = np.tile(END.end, (4, 1))
    pose[1:, :3] += 0.1 * END.outward
    pose[2, 1] += 0.01
    pose[3, 5] += np.deg2rad(1.5)
    across, tilt = END.excess(pose).T
    assert across[0] == pytest.approx(0.0, abs=1e-12)
    assert across[1] == pytest.approx(-0.1 * np.tan(np.deg2rad(3.0)))
    assert across[2] == pytest.approx(0.01 - 0.1 * np.tan(np.deg2rad(3.0)))
    assert tilt[3] == pytest.approx(np.deg2rad(0.5))


def test_meshes_are_denser_where_ends_are_straight() -> None:
    """Eight intervals and four spans in each, as many beyond, nodes at the approach poses, ends as they are."""
    mesh = with_straight_ends(even_mesh(50, 20, np.zeros(0)), np.array([0.03, 0.98]))
    for s, spans in ((mesh.s, 8), (np.unique(mesh.knots), 4)):
        assert (s[0], s[-1]) == (0.0, 1.0)
        for low, high in ((0.0, 0.03), (0.03, 0.06), (0.96, 0.98), (0.98, 1.0)):
            assert np.count_nonzero((s > low - 1e-9) & (s < high + 1e-9)) == spans + 1
        assert np.diff(s).min() > 1e-3
    assert np.isin([0.03, 0.98], mesh.s.round(12)).all()


@pytest.fixture(scope="module")
def straight_config(light_config: Config, vary: Vary) -> Config:
    """Ask for straight ends in directions along no axis."""
    keys = {
        "task.goal": {"x_m": 1.2, "y_m": 0.5, "z_m": 0.9, "mode": "LLL"},
        "refine.approach_m": 0.05,
        "refine.start_direction": [0.5, 1.0, 0.3],
        "refine.goal_direction": [0.2, 0.1, -1.0],
    }
    return vary(light_config, keys)


@pytest.fixture(scope="module")
def straight_route(straight_config: Config, machine: Machine) -> Route:
    """Plan it."""
    return plan_route(straight_config, machine, build_regions(straight_config, machine))


@pytest.fixture(scope="module")
def found(straight_config: Config, machine: Machine, straight_route: Route) -> Refinement:
    """Refine it."""
    return refine_path(straight_config, machine, straight_route)


def test_every_chord_from_a_straight_end_is_within_3_degrees_of_its_direction(
    straight_config: Config, machine: Machine, straight_route: Route, found: Refinement
) -> None:
    """Also at 1, 10 and 50 mm, where the path passes the approach pose exactly; and the path is certified."""
    for end in straight_ends(straight_config, straight_route, found.coarse):
        s = end.s_end + np.geomspace(1e-4, 1.0, 500) * (end.s - end.s_end)
        pose = found.path.pose(np.sort(s))
        pose = pose if end.name == "start" else pose[::-1]
        away = pose[:, :3] - end.end[:3]
        angle = np.rad2deg(np.arccos(np.clip(away @ end.outward / np.linalg.norm(away, axis=1), -1.0, 1.0)))
        assert angle.max() < 3.0
        np.testing.assert_allclose(np.linalg.norm(away[-1]), 0.05, atol=1e-6)
        assert np.rad2deg(np.abs(pose[:, [3, 5]] - end.end[[3, 5]]).max()) < 1.0
    assert certify_path(straight_config, machine, found.path).verdict == "certified"


def test_the_check_between_the_nodes_names_the_end_that_is_left_askew(
    straight_config: Config, straight_route: Route, found: Refinement, vary: Vary
) -> None:
    """A path that keeps its own directions breaks another one at the goal, and nothing else."""
    other = vary(straight_config, {"refine.goal_direction": [0.4, 0.1, -1.0]})
    (violation,) = find_violations(other, straight_route, found.path, found.coarse)
    assert "straight line at the goal" in violation.what
    assert "refine.goal_direction" in violation.advice
